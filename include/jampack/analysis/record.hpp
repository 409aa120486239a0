// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <string_view>
#include <tuple>
#include <utility>

namespace jampack {

/// Names its columns at compile time: `static constexpr std::array<std::string_view, n> columns`.
template <class A>
concept HasColumns = requires {
  { A::columns.size() } -> std::convertible_to<std::size_t>;
  { A::columns[0] } -> std::convertible_to<std::string_view>;
};

/// An analysis of a state: a small value type that carries its own parameters, names its columns and computes
/// one number for each, without changing the state.
template <class A, class State>
concept Analysis = HasColumns<A> && std::copy_constructible<A> && requires(const A& a, const State& state) {
  { a(state) } -> std::same_as<std::array<double, A::columns.size()>>;
};

/// A list of analyses chosen at compile time, itself an analysis: its columns and values are theirs, in
/// order. An analysis that is not named is not instantiated, and one without parameters takes no space.
///
///   const Analyses record{PackingFraction{}, Pressure{.modulus = 1}};
///   write_header(record.columns);  write_row(record(state));
template <HasColumns... Listed>
class Analyses {
 public:
  static constexpr std::size_t n_columns = (std::size_t{0} + ... + Listed::columns.size());

  static constexpr std::array<std::string_view, n_columns> columns = [] {
    std::array<std::string_view, n_columns> all{};
    [[maybe_unused]] auto place = all.begin();
    ((place = std::copy(Listed::columns.begin(), Listed::columns.end(), place)), ...);
    return all;
  }();

  Analyses() = default;
  explicit Analyses(Listed... listed) requires(sizeof...(Listed) > 0) : listed_(std::move(listed)...) {}

  template <class State>
  std::array<double, n_columns> operator()(const State& state) const {
    static_assert(
        (Analysis<Listed, State> && ...),
        "every analysis of the list must be callable with this state and return one double a column");
    std::array<double, n_columns> values{};
    auto place = values.begin();
    const auto compute = [&](const auto& analysis) {
      const auto own = analysis(state);
      place = std::copy(own.begin(), own.end(), place);
    };
    std::apply([&](const auto&... analysis) { (compute(analysis), ...); }, listed_);
    return values;
  }

  /// Position of a column; asking for one the list has not does not compile.
  static consteval std::size_t column(std::string_view name) {
    const auto found = std::find(columns.begin(), columns.end(), name);
    if (found == columns.end()) throw "no analysis of the list has a column of this name";
    return static_cast<std::size_t>(found - columns.begin());
  }

 private:
  static_assert(
      [] {
        for (std::size_t i = 0; i < n_columns; ++i)
          for (std::size_t j = 0; j < i; ++j)
            if (columns[i] == columns[j]) return false;
        return true;
      }(),
      "two analyses of the list have a column of the same name");

  std::tuple<Listed...> listed_;
};

}  // namespace jampack
