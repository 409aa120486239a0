// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <jampack/solver/local_solver.hpp>
#include <type_traits>
#include <utility>

namespace jampack {

/// One contact update of Gauss–Seidel, for any Delassus operator: its velocity, the exact local solution, the
/// change of motion. Set up once for a problem, which it refers to; visit() allocates nothing.
///
/// An update is a chain of operations that wait for each other. So nothing of it may pass through memory:
/// all that it calls is inlined, and loops over unknowns, here and there, are unrolled by pragma (compilers
/// leave them rolled, and what a rolled loop indexes lies in memory).
template <class Problem>
class ContactKernel {
  static constexpr int N = Problem::n_unknowns;
  using Delassus = typename Problem::DelassusType;
  using Block = std::remove_cvref_t<decltype(std::declval<const Delassus&>().diagonal_block(Index{}))>;

 public:
  ContactKernel(const Problem& problem, const Eigen::VectorXd& r)
      : problem_(problem), motion_(problem.delassus.motion(r)) {
    record_.reserve(problem.n_contacts());
    for (Index c = 0; c < problem.n_contacts(); ++c) {
      Record record{LocalSolver<N, Block>(problem.delassus.diagonal_block(c)), problem.law[c], {}, c};
      for (int i = 0; i < N; ++i)
        record.free_velocity[static_cast<std::size_t>(i)] = problem.free_velocity[N * c + i];
      record_.push_back(record);
    }
  }

  /// To be called when r was changed from outside.
  void restart(const Eigen::VectorXd& r) { motion_ = problem_.delassus.motion(r); }

  /// Gives the contacts places in memory: the k-th place to order[k]. Until then contact c has place c.
  void arrange(const Array<Index>& order) {
    Array<Record> arranged(record_.size());
    for (const Record& record : record_) arranged[record.contact] = record;
    for (Index k = 0; k < order.size(); ++k) record_[k] = arranged[order[k]];
  }

  /// Updates the contacts at the places from `first` to before `last`, in that order; returns the sum of
  /// |dr_c|^2.
  double visit(const Index* first, const Index* last, Eigen::VectorXd& r, double relaxation) {
    return relaxation == 1 ? visit<false>(first, last, r, 1) : visit<true>(first, last, r, relaxation);
  }

 private:
  /// What an update reads of a contact besides its row of W: together, as every array more is one stream
  /// more that the processor has to fetch ahead.
  struct Record {
    LocalSolver<N, Block> local;
    typename Problem::LocalLaw law;
    std::array<double, N> free_velocity;
    Index contact;
  };

  template <bool relaxed>
  double visit(const Index* first, const Index* last, Eigen::VectorXd& r, double relaxation) {
    double changed = 0;
    for (; first != last; ++first) changed += update<relaxed>(record_[*first], r, relaxation);
    return changed;
  }

  template <bool relaxed>
  [[gnu::always_inline]] double update(const Record& record, Eigen::VectorXd& r, double relaxation) {
    const Index c = record.contact;
    ContactVector<N> old, u = problem_.delassus.velocity(motion_, r, c);
#pragma GCC unroll 9
    for (int i = 0; i < N; ++i) {
      old[i] = r[N * c + i];
      u[i] += record.free_velocity[static_cast<std::size_t>(i)];
    }
    ContactVector<N> next = record.local.solve(record.law, u, old);
    if constexpr (relaxed) {
#pragma GCC unroll 9
      for (int i = 0; i < N; ++i) next[i] = old[i] + relaxation * (next[i] - old[i]);
      next = project_on_friction_cone<N>(next, record.law.friction);
    }
    ContactVector<N> dr;
    double changed = 0;
#pragma GCC unroll 9
    for (int i = 0; i < N; ++i) {
      dr[i] = next[i] - old[i];
      changed += dr[i] * dr[i];
      r[N * c + i] = next[i];
    }
    // Where nothing but r is kept up to date, asking costs more than it saves: the answer cannot be foreseen.
    if (!std::is_empty_v<typename Delassus::Motion> && changed == 0) return 0;
    problem_.delassus.change(motion_, c, dr);
    return changed;
  }

  const Problem& problem_;
  typename Delassus::Motion motion_;
  Array<Record> record_;  // by place
};

}  // namespace jampack
