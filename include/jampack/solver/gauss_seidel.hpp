// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <jampack/core/parallel.hpp>
#include <jampack/core/splitmix.hpp>
#include <jampack/solver/colouring.hpp>
#include <jampack/solver/contact_kernel.hpp>
#include <jampack/solver/contact_solver.hpp>
#include <jampack/solver/thread_plan.hpp>

namespace jampack {

/// Order in which a sweep visits the contacts.
enum class SweepOrder {
  natural,    ///< as numbered
  symmetric,  ///< forwards, then backwards, in turn
  shuffled,   ///< a new order each sweep, from `seed`
  coloured,   ///< colour by colour, for threads: the same bits whatever their number
};

/// Nonlinear (block) Gauss–Seidel: contact by contact, the local solution with all others held (M. Jean,
/// Comput. Methods Appl. Mech. Engrg. 177 (1999) 235), exact but for how far sliding directions are followed
/// (SlipAccuracy::for_a_sweep). Stops on scaled_residual, recomputed from
/// W r + q; the sum of the changes of a sweep only decides when that test is worth its price.
struct GaussSeidel {
  StoppingCriterion stop{};
  SweepOrder order = SweepOrder::natural;
  double relaxation = 1;  ///< in (0, 2): factor on each change of a reaction
  std::uint64_t seed = 1;
  Threads threads{};  ///< used by the coloured order only; the others are sequential by nature

  template <class Problem>
  SolveReport solve(const Problem& problem, Eigen::VectorXd& r) const;
};

/// The data of Gauss–Seidel sweeps over one problem, set up once; sweep() allocates nothing.
template <class Problem, SlipAccuracy accuracy = SlipAccuracy::for_a_sweep>
class GaussSeidelSweeps {
 public:
  GaussSeidelSweeps(const Problem& problem, const Eigen::VectorXd& r)
      : kernel_(problem, r), order_(problem.n_contacts()) {
    for (Index c = 0; c < problem.n_contacts(); ++c) order_[c] = c;
  }

  /// Colours the contacts of the problem; from then on sweeps go colour by colour, on so many threads.
  void colour(const Problem& problem, Threads threads) {
    colouring_ = colour_contacts(problem.delassus);
    kernel_.arrange(colouring_.order);
    changed_.resize(colouring_.chunks.size());
    plan_ = plan_threads(colouring_, threads);
  }

  /// To be called when r was changed from outside.
  void restart(const Eigen::VectorXd& r) { kernel_.restart(r); }

  /// Visits all contacts once in the present order and changes r. Returns the sum of |dr_c|^2.
  double sweep(Eigen::VectorXd& r, double relaxation = 1) {
    const double changed = advance(r, relaxation);
    collect(r);
    return changed;
  }

  /// The same for several sweeps in a row: r may be out of date until it is collected.
  double advance(Eigen::VectorXd& r, double relaxation = 1) {
    if (!colouring_.classes.empty()) return coloured_sweep(r, relaxation);
    return kernel_.visit(0, order_.size(), backwards_, r, relaxation);
  }

  void collect(Eigen::VectorXd& r) const { kernel_.collect(r); }

  void reverse() { backwards_ = !backwards_; }
  void shuffle(std::uint64_t& state) {
    jampack::shuffle(order_, state);
    kernel_.arrange(order_);
  }

 private:
  double coloured_sweep(Eigen::VectorXd& r, double relaxation) {
    for_each_chunk(colouring_, plan_, [&](Index k) {
      const auto& chunk = colouring_.chunks[k];
      changed_[k] = kernel_.visit(chunk.first, chunk.last, false, r, relaxation);
    });
    double changed = 0;  // summed in the order of the chunks, whoever visited them
    for (const double x : changed_) changed += x;
    return changed;
  }

  ContactKernel<Problem, accuracy> kernel_;
  Array<Index> order_;  // shuffled
  bool backwards_ = false;
  Colouring colouring_;
  Array<double> changed_;  // by chunk
  ThreadPlan plan_;
};

template <class Problem>
SolveReport GaussSeidel::solve(const Problem& problem, Eigen::VectorXd& r) const {
  require(relaxation > 0 && relaxation < 2, "Gauss-Seidel: relaxation must lie in (0, 2)");
  BestIterate<Problem> iterate(problem, stop, r);
  Index n_sweeps = 0;
  if (!iterate.converged() && problem.n_contacts() > 0) {
    GaussSeidelSweeps<Problem> sweeps(problem, r);
    if (order == SweepOrder::coloured) sweeps.colour(problem, threads);
    std::uint64_t state = seed;
    Index next_test = 1;
    while (!iterate.converged() && n_sweeps < stop.max_sweeps) {
      if (order == SweepOrder::shuffled) sweeps.shuffle(state);
      const double changed = std::sqrt(sweeps.advance(r, relaxation));
      if (order == SweepOrder::symmetric) sweeps.reverse();
      ++n_sweeps;
      // A test costs less than a sweep: every tenth, later more seldom, or when a sweep changes hardly
      // anything.
      const bool settled = changed <= stop.tolerance * r.norm();
      if (n_sweeps < next_test && !settled && n_sweeps < stop.max_sweeps) continue;
      sweeps.collect(r);
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
