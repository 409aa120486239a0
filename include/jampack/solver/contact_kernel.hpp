// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <jampack/solver/local_solver.hpp>
#include <type_traits>
#include <utility>

namespace jampack {

/// One contact update of Gauss–Seidel, for any Delassus operator: its velocity, the local solution, the
/// change of motion. Set up once for a problem, which it refers to; visit() allocates nothing.
///
/// An update is a chain of operations that wait for each other. So nothing of it may pass through memory:
/// all that it calls is inlined, and loops over unknowns, here and there, are unrolled by pragma (compilers
/// leave them rolled, and what a rolled loop indexes lies in memory).
template <class Problem, SlipAccuracy accuracy = SlipAccuracy::for_a_sweep>
class ContactKernel {
  static constexpr int N = Problem::n_unknowns;
  using Delassus = typename Problem::DelassusType;
  using Block = std::remove_cvref_t<decltype(std::declval<const Delassus&>().diagonal_block(Index{}))>;

 public:
  /// Whether updates read reactions from the motion alone: arranged contacts then keep theirs beside their
  /// data, where no other thread's are in the same cache line, until they are collected.
  static constexpr bool keeps_reactions = !std::is_empty_v<typename Delassus::Motion>;

  ContactKernel(const Problem& problem, const Eigen::VectorXd& r)
      : problem_(problem), motion_(problem.delassus.motion(r)) {
    record_.reserve(problem.n_contacts());
    for (Index c = 0; c < problem.n_contacts(); ++c) {
      Record record{LocalSolver<N, Block>(problem.delassus.diagonal_block(c)), problem.law[c], {}, {}, c};
      for (int i = 0; i < N; ++i)
        record.free_velocity[static_cast<std::size_t>(i)] = problem.free_velocity[N * c + i];
      record_.push_back(record);
    }
    hand_out(r);
  }

  /// To be called when r was changed from outside.
  void restart(const Eigen::VectorXd& r) {
    motion_ = problem_.delassus.motion(r);
    hand_out(r);
  }

  /// Brings r up to date after visits to arranged contacts.
  void collect(Eigen::VectorXd& r) const {
    if (!keeps_reactions || !arranged_) return;
    for (const Record& record : record_)
      for (int i = 0; i < N; ++i) r[N * record.contact + i] = record.reaction[static_cast<std::size_t>(i)];
  }

  /// Gives the contacts places in memory: the k-th place to order[k]. Until then contact c has place c.
  void arrange(const Array<Index>& order) {
    Array<Record>& arranged = spare_;
    arranged.resize(record_.size());
    for (const Record& record : record_) arranged[record.contact] = record;
    for (Index k = 0; k < order.size(); ++k) record_[k] = arranged[order[k]];
    arranged_ = true;
  }

  /// Updates the contacts at the places from `first` to before `last`, in that order or backwards; returns
  /// the sum of |dr_c|^2.
  double visit(Index first, Index last, bool backwards, Eigen::VectorXd& r, double relaxation) {
    const Range range = backwards ? Range{last - 1, first - 1, -1} : Range{first, last, 1};
    if (arranged_)
      return relaxation == 1 ? visit<true, false>(range, r, 1) : visit<true, true>(range, r, relaxation);
    return relaxation == 1 ? visit<false, false>(range, r, 1) : visit<false, true>(range, r, relaxation);
  }

 private:
  /// What an update reads of a contact besides its row of W: together, as every array more is one stream
  /// more that the processor has to fetch ahead.
  struct Record {
    LocalSolver<N, Block> local;
    typename Problem::LocalLaw law;
    std::array<double, N> free_velocity, reaction;
    Index contact;
  };

  void hand_out(const Eigen::VectorXd& r) {
    for (Record& record : record_)
      for (int i = 0; i < N; ++i) record.reaction[static_cast<std::size_t>(i)] = r[N * record.contact + i];
  }

  struct Range {
    Index first, last, step;
  };

  // A contact that is known without reading its record lets the processor fetch its row, and all that the row
  // names, updates ahead. Where an operator can begin a velocity before the update that precedes it, that is
  // done, as the processor looks ahead no farther than some one or two updates. (One unknown: not worth it.)
  template <bool arranged, bool relaxed>
  double visit(const Range& range, Eigen::VectorXd& r, double relaxation) {
    double changed = 0;
    const Delassus& w = problem_.delassus;
    if constexpr (!arranged && N > 1 && requires { w.begin_velocity(r, Index{}); }) {
      if (range.step > 0 && range.first < range.last) {
        ContactVector<N> begun = w.begin_velocity(r, range.first);
        for (Index c = range.first; c < range.last; ++c) {
          fetch(c + far_ahead);
          const ContactVector<N> next = w.begin_velocity(r, std::min(c + 1, range.last - 1));
          changed +=
              update<relaxed>(record_[c], c, w.end_velocity(begun, r, c), r.data() + N * c, relaxation);
          begun = next;
        }
        return changed;
      }
    }
    for (Index k = range.first; k != range.last; k += range.step) {
      fetch(k + far_ahead * range.step);
      const Index c = arranged ? record_[k].contact : k;
      double* const own = arranged && keeps_reactions ? record_[k].reaction.data() : r.data() + N * c;
      changed += update<relaxed>(record_[k], c, w.velocity(motion_, r, c), own, relaxation);
    }
    return changed;
  }

  // Asks for what the update at a place some way ahead will read, if that lies far away.
  static constexpr Index far_ahead = 8;
  [[gnu::always_inline]] void fetch(Index place) const {
    const Delassus& w = problem_.delassus;
    if constexpr (requires { w.fetch_row(place); }) {
      if (!w.is_far() || place < 0 || place >= record_.size()) return;
      for (std::size_t k = 0; k < sizeof(Record); k += 64)
        __builtin_prefetch(reinterpret_cast<const char*>(&record_[place]) + k);
      w.fetch_row(arranged_ ? record_[place].contact : place);
    }
  }

  template <bool relaxed>
  [[gnu::always_inline]] double update(const Record& record, Index c, ContactVector<N> u, double* r,
                                       double relaxation) {
    ContactVector<N> old;
#pragma GCC unroll 9
    for (int i = 0; i < N; ++i) {
      old[i] = r[i];
      u[i] += record.free_velocity[static_cast<std::size_t>(i)];
    }
    ContactVector<N> next = record.local.template solve<accuracy>(record.law, u, old);
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
      r[i] = next[i];
    }
    // Where nothing but r is kept up to date, asking costs more than it saves: the answer cannot be foreseen.
    if (!std::is_empty_v<typename Delassus::Motion> && changed == 0) return 0;
    problem_.delassus.change(motion_, c, dr);
    return changed;
  }

  const Problem& problem_;
  typename Delassus::Motion motion_;
  Array<Record> record_, spare_;  // by place
  bool arranged_ = false;
};

}  // namespace jampack
