// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <jampack/solver/contact_solver.hpp>
#include <jampack/solver/local_solver.hpp>
#include <type_traits>

namespace jampack {

/// Order in which a sweep visits the contacts.
enum class SweepOrder {
  natural,    ///< as numbered
  symmetric,  ///< forwards, then backwards, in turn
  shuffled,   ///< a new order each sweep, from `seed`
};

/// Nonlinear (block) Gauss–Seidel: contact by contact, the exact local solution with all others held
/// (M. Jean, Comput. Methods Appl. Mech. Engrg. 177 (1999) 235). Stops on scaled_residual, recomputed from
/// W r + q; the sum of the changes of a sweep only decides when that test is worth its price.
struct GaussSeidel {
  StoppingCriterion stop{};
  SweepOrder order = SweepOrder::natural;
  double relaxation = 1;  ///< in (0, 2): factor on each change of a reaction
  std::uint64_t seed = 1;

  template <class Problem>
  SolveReport solve(const Problem& problem, Eigen::VectorXd& r) const;
};

/// The data of Gauss–Seidel sweeps over one problem, set up once; sweep() allocates nothing.
template <class Problem>
class GaussSeidelSweeps {
  static constexpr int N = Problem::n_unknowns;
  using Delassus = typename Problem::DelassusType;
  using Block = std::remove_cvref_t<decltype(std::declval<const Delassus&>().diagonal_block(Index{}))>;

 public:
  GaussSeidelSweeps(const Problem& problem, const Eigen::VectorXd& r)
      : problem_(problem), motion_(problem.delassus.motion(r)), order_(problem.n_contacts()) {
    local_.reserve(problem.n_contacts());
    for (Index c = 0; c < problem.n_contacts(); ++c) {
      local_.push_back(LocalSolver<N, Block>(problem.delassus.diagonal_block(c)));
      order_[c] = c;
    }
  }

  /// To be called when r was changed from outside.
  void restart(const Eigen::VectorXd& r) { motion_ = problem_.delassus.motion(r); }

  /// Visits all contacts once in the present order and changes r. Returns the sum of |dr_c|^2.
  double sweep(Eigen::VectorXd& r, double relaxation = 1) {
    double changed = 0;
    for (const Index c : order_) changed += visit(c, r, relaxation);
    return changed;
  }

  /// One contact; returns |dr_c|^2.
  double visit(Index c, Eigen::VectorXd& r, double relaxation = 1) {
    const ContactVector<N> old = r.template segment<N>(N * c);
    const ContactVector<N> u =
        problem_.delassus.velocity(motion_, r, c) + problem_.free_velocity.template segment<N>(N * c);
    ContactVector<N> next = local_[c].solve(problem_.law[c], u, old);
    if (relaxation != 1)
      next = project_on_friction_cone<N>(old + relaxation * (next - old), problem_.law[c].friction);
    const ContactVector<N> dr = next - old;
    const double changed = dr.squaredNorm();
    if (changed == 0) return 0;
    r.template segment<N>(N * c) = next;
    problem_.delassus.change(motion_, c, dr);
    return changed;
  }

  void reverse() { std::reverse(order_.begin(), order_.end()); }
  void shuffle(std::uint64_t& state) {
    for (Index i = order_.size() - 1; i > 0; --i) {
      // splitmix64: the same order on every machine.
      std::uint64_t z = (state += 0x9e3779b97f4a7c15u);
      z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
      z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
      std::swap(order_[i], order_[static_cast<Index>((z ^ (z >> 31)) % static_cast<std::uint64_t>(i + 1))]);
    }
  }

 private:
  const Problem& problem_;
  typename Delassus::Motion motion_;
  Array<LocalSolver<N, Block>> local_;
  Array<Index> order_;
};

template <class Problem>
SolveReport GaussSeidel::solve(const Problem& problem, Eigen::VectorXd& r) const {
  require(relaxation > 0 && relaxation < 2, "Gauss-Seidel: relaxation must lie in (0, 2)");
  BestIterate<Problem> iterate(problem, stop, r);
  Index n_sweeps = 0;
  if (!iterate.converged() && problem.n_contacts() > 0) {
    GaussSeidelSweeps<Problem> sweeps(problem, r);
    std::uint64_t state = seed;
    Index next_test = 1;
    while (!iterate.converged() && n_sweeps < stop.max_sweeps) {
      if (order == SweepOrder::shuffled) sweeps.shuffle(state);
      const double changed = std::sqrt(sweeps.sweep(r, relaxation));
      if (order == SweepOrder::symmetric) sweeps.reverse();
      ++n_sweeps;
      // A test costs less than a sweep: every tenth, later more seldom, or when a sweep changes hardly
      // anything.
      const bool settled = changed <= stop.tolerance * r.norm();
      if (n_sweeps < next_test && !settled && n_sweeps < stop.max_sweeps) continue;
      iterate.judge(r);
      sweeps.restart(r);
      next_test = n_sweeps + std::max<Index>(n_sweeps < 10 ? 3 : 10, n_sweeps / 20);
      if (iterate.out_of_time()) break;
    }
    r = iterate.best();
  }
  return iterate.report(n_sweeps);
}

}  // namespace jampack
