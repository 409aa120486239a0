// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <jampack/io/file.hpp>
#include <jampack/io/number.hpp>
#include <jampack/law/hertz_check.hpp>
#include <jampack/law/signorini.hpp>
#include <jampack/law/signorini_coulomb.hpp>
#include <jampack/problem/block_sparse_delassus.hpp>
#include <jampack/problem/contact_problem.hpp>
#include <jampack/problem/stored_blocks.hpp>
#include <sstream>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>

namespace jampack {

template <int N>
using StoredContactProblem =
    ContactProblem<BlockSparseDelassus<N>, std::conditional_t<N == 1, Signorini, SignoriniCoulomb>>;
template <int N>
using StoredCompliantProblem =
    ContactProblem<BlockSparseDelassus<N>, std::conditional_t<N == 1, HertzCheck, HertzCheckCoulomb>>;

/// A problem read from a file, whose number of unknowns a contact is known only then.
using AnyContactProblem =
    std::variant<StoredContactProblem<1>, StoredContactProblem<2>, StoredContactProblem<3>,
                 StoredCompliantProblem<1>, StoredCompliantProblem<2>, StoredCompliantProblem<3>>;

/// A problem and a first guess of its reactions (empty where the file holds none).
struct ContactProblemFile {
  AnyContactProblem problem;
  Eigen::VectorXd guess;
};

/// The text format for contact problems. Words and numbers separated by white space; '#' comments to the end
/// of the line:
///
///   jampack-contact-problem 1      format version
///   unknowns N                     a contact: 1 frictionless, 2 in 2D, 3 in 3D; order N, T1, T2
///   contacts n
///   friction       n values        Coulomb's coefficients (any N; not used for N = 1)
///   compliance     n pairs         optional: coefficient and exponent of c(r) (law/hertz_check.hpp)
///   free_velocity  N n values      q
///   step           n values        optional: the problem's own steps rho_c of the natural map
///   guess          N n values      optional: a first guess of the reactions
///   blocks k                       k times: row column (from 0), then the N x N block row by row; blocks
///                                  given twice are added
///   end
template <class Problem>
std::string contact_problem_text(const Problem& problem, const Eigen::VectorXd& guess = {}) {
  constexpr int N = Problem::n_unknowns;
  std::string text = "jampack-contact-problem 1\nunknowns " + std::to_string(N) + "\ncontacts " +
                     std::to_string(problem.n_contacts()) + "\n";
  const auto vector = [&](const char* name, const Eigen::VectorXd& values) {
    text += name;
    for (Index i = 0; i < values.size(); ++i) text += (i % N == 0 ? "\n" : " ") + to_text(values[i]);
    text += "\n";
  };
  text += "friction";
  for (const auto& law : problem.law) text += " " + to_text(static_cast<double>(law.friction));
  text += "\n";
  if constexpr (Problem::LocalLaw::is_compliant) {
    text += "compliance\n";
    for (const auto& law : problem.law) text += to_text(law.coefficient) + " " + to_text(law.exponent) + "\n";
  }
  vector("free_velocity", problem.free_velocity);
  if (!problem.step.empty()) {
    text += "step";
    for (const double step : problem.step) text += " " + to_text(step);
    text += "\n";
  }
  if (guess.size() > 0) vector("guess", guess);
  const auto blocks = stored_blocks(as_block_sparse(problem.delassus));
  text += "blocks " + std::to_string(blocks.size()) + "\n";
  for (const auto& block : blocks) {
    text += std::to_string(block.row) + " " + std::to_string(block.column);
    for (int i = 0; i < N; ++i)
      for (int j = 0; j < N; ++j) text += " " + to_text(block.value(i, j));
    text += "\n";
  }
  return text + "end\n";
}

/// Writes a problem, as a simulation does with one it could not solve. Throws Error if it cannot.
template <class Problem>
void write_contact_problem(const std::filesystem::path& path, const Problem& problem,
                           const Eigen::VectorXd& guess = {}) {
  write_file(path, contact_problem_text(problem, guess));
}

namespace detail {

class ContactProblemParser {
 public:
  ContactProblemParser(std::string_view text, std::string source) : text_(text), source_(std::move(source)) {}

  std::string word() {
    while (position_ < text_.size() && (is_space(text_[position_]) || text_[position_] == '#')) {
      if (text_[position_] == '#')
        while (position_ < text_.size() && text_[position_] != '\n') ++position_;
      else
        ++position_;
    }
    const std::size_t start = position_;
    while (position_ < text_.size() && !is_space(text_[position_]) && text_[position_] != '#') ++position_;
    return std::string(text_.substr(start, position_ - start));
  }
  void expect(const std::string& wanted) {
    const std::string found = word();
    check(found == wanted, "expected '" + wanted + "', found '" + found + "'");
  }
  template <Number T>
  T number(const char* what) {
    const std::string found = word();
    const auto value = to_number<T>(found);
    check(value.has_value(), std::string("expected ") + what + ", found '" + found + "'");
    return *value;
  }
  Index count(const char* what) {
    const Index n = number<Index>(what);
    // Every item takes at least two characters: an honest count fits the file.
    check(n >= 0 && n <= static_cast<Index>(text_.size()), std::string("impossible ") + what);
    return n;
  }
  Eigen::VectorXd vector(Index n, const char* what) {
    Eigen::VectorXd values(n);
    for (Index i = 0; i < n; ++i) values[i] = number<double>(what);
    return values;
  }
  void check(bool condition, const std::string& message) const {
    require(condition, source_ + ": " + message);
  }

 private:
  static bool is_space(char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; }
  std::string_view text_;
  std::string source_;
  std::size_t position_ = 0;
};

template <int N>
ContactProblemFile parse_contact_problem(ContactProblemParser& parser) {
  parser.expect("contacts");
  const Index n = parser.count("a number of contacts");
  parser.expect("friction");
  const Eigen::VectorXd friction = parser.vector(n, "a friction coefficient");
  std::string section = parser.word();
  Eigen::VectorXd compliance, step, guess;
  if (section == "compliance") {
    compliance = parser.vector(2 * n, "a compliance");
    for (Index c = 0; c < n; ++c)
      parser.check(compliance[2 * c] >= 0 && compliance[2 * c + 1] > 0 && compliance[2 * c + 1] <= 1,
                   "a compliance needs a coefficient >= 0 and an exponent in (0, 1]");
    section = parser.word();
  }
  parser.check(section == "free_velocity", "expected 'free_velocity', found '" + section + "'");
  const Eigen::VectorXd q = parser.vector(N * n, "a free velocity");
  section = parser.word();
  if (section == "step") {
    step = parser.vector(n, "a step of the natural map");
    parser.check(n == 0 || (step.minCoeff() > 0 && step.allFinite()),
                 "a step of the natural map must be positive and finite");
    section = parser.word();
  }
  if (section == "guess") {
    guess = parser.vector(N * n, "a reaction");
    parser.check(guess.allFinite(), "the guess is not finite");
    section = parser.word();
  }
  parser.check(section == "blocks", "expected 'blocks', found '" + section + "'");
  Array<DelassusBlock<N>> blocks(parser.count("a number of blocks"));
  for (auto& block : blocks) {
    block.row = parser.template number<Index>("a row");
    block.column = parser.template number<Index>("a column");
    for (int i = 0; i < N; ++i)
      for (int j = 0; j < N; ++j) block.value(i, j) = parser.template number<double>("a value of W");
  }
  parser.expect("end");
  BlockSparseDelassus<N> delassus(n, std::move(blocks));
  const auto with_guess = [&](auto problem) -> ContactProblemFile {
    problem.step = Array<double>(step.begin(), step.end());
    return {std::move(problem), guess};
  };
  if (compliance.size() > 0) {
    using Problem = StoredCompliantProblem<N>;
    Array<CompliantContact> law(n);
    for (Index c = 0; c < n; ++c) law[c] = {compliance[2 * c], compliance[2 * c + 1], friction[c]};
    return with_guess(Problem(std::move(delassus), q, std::move(law)));
  }
  using Problem = StoredContactProblem<N>;
  Array<typename Problem::LocalLaw> law(n);
  if constexpr (N > 1)
    for (Index c = 0; c < n; ++c) law[c].friction = friction[c];
  return with_guess(Problem(std::move(delassus), q, std::move(law)));
}

}  // namespace detail

/// Reads a problem in the text format. Throws InvalidInput with what is wrong.
inline ContactProblemFile parse_contact_problem(std::string_view text,
                                                const std::string& source = "contact problem") {
  detail::ContactProblemParser parser(text, source);
  parser.expect("jampack-contact-problem");
  parser.expect("1");
  parser.expect("unknowns");
  const Index n = parser.count("a number of unknowns");
  parser.check(n >= 1 && n <= 3, "a contact has 1, 2 or 3 unknowns");
  if (n == 1) return detail::parse_contact_problem<1>(parser);
  if (n == 2) return detail::parse_contact_problem<2>(parser);
  return detail::parse_contact_problem<3>(parser);
}

inline ContactProblemFile read_contact_problem(const std::filesystem::path& path) {
  return parse_contact_problem(read_file(path), path.string());
}

}  // namespace jampack
