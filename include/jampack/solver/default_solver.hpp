// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <jampack/solver/admm.hpp>
#include <jampack/solver/gauss_seidel.hpp>
#include <jampack/solver/proximal_newton.hpp>

namespace jampack {

/// The solver for whoever does not want to choose: sweeps while they promise to end soon, then proximal
/// Newton steps, which want few iterations where sweeps want thousands (stiff or redundant contacts); if
/// those give up, ADMM, longer sweeps and another start, in turn. The choice depends on residuals and counts,
/// never on a clock.
struct DefaultSolver {
  StoppingCriterion stop{};
  Index patience =
      300;  ///< sweeps that the rate of convergence may promise before Newton's method takes over
  Index max_newton_contacts = 20000;  ///< beyond, W is not factorised: sweeps only

  template <class Problem>
  SolveReport solve(const Problem& problem, Eigen::VectorXd& r) const {
    BestIterate<Problem> iterate(problem, stop, r);
    Index n_sweeps = 0;
    if (iterate.converged() || problem.n_contacts() == 0) return iterate.report(0);
    const bool can_factorise = problem.n_contacts() <= max_newton_contacts;
    const auto no_price = [] { return Index{0}; };
    constexpr Index dear = 5000;  // sweeps
    Index known_price = -1;
    const auto newton_price = [&] {  // asked for when patience is at an end
      using Matrix = NewtonMatrix<typename Problem::DelassusType>;
      if (known_price < 0) known_price = Matrix::factorisation_in_sweeps(problem.delassus) * 15;
      return known_price;
    };
    if (can_factorise)
      sweep_while_promising(problem, r, iterate, patience, n_sweeps, newton_price);
    else
      sweep_while_promising(problem, r, iterate, stop.max_sweeps, n_sweeps, no_price);
    double regularisation = ProximalNewton{}.regularisation;
    for (int round = 0; round < 6 && can_factorise && going_on(iterate, n_sweeps); ++round) {
      // Sweeps after a step that cost no more than half its factors (of a long chain nearly nothing: there
      // they would hide the error that is left). More or fewer: each loses some problem that the other
      // solves.
      const Index most_smoothing = std::clamp<Index>(newton_price() / 30, 2, 5);
      ProximalNewton newton{.stop = stop,
                            .regularisation = regularisation,
                            .first_sweeps = round == 0 ? 0 : 20,
                            .smoothing = round % 2 == 0 ? most_smoothing : 2};
      // Sweeps may be right after all: where factors are dear, both get about the same time.
      const Index most = (newton_price() > dear ? Index{50} : Index{500}) << round, before = n_sweeps;
      newton.stop.max_sweeps = std::min<Index>(most, stop.max_sweeps - n_sweeps);
      newton.stop.time_limit = stop.time_limit - iterate.report(0).seconds;
      r = iterate.best();
      n_sweeps += newton.solve(problem, r).sweeps;
      const Index worth = newton_price() > dear ? newton_price() / 15 * (n_sweeps - before) : 0;
      iterate.judge(r);
      if (!going_on(iterate, n_sweeps)) break;
      alternate_directions(problem, r, iterate, Index{1000} << round, n_sweeps);
      if (!going_on(iterate, n_sweeps)) break;
      // Another start, from longer sweeps and with more or less regularisation.
      sweep_while_promising(problem, r, iterate, std::max(Index{100} << round, worth), n_sweeps, no_price);
      regularisation = round % 2 == 0 ? 1e-1 : 1e-5;
    }
    if (going_on(iterate, n_sweeps))
      sweep_while_promising(problem, r, iterate, stop.max_sweeps, n_sweeps, no_price);
    r = iterate.best();
    return iterate.report(n_sweeps);
  }

 private:
  template <class Problem>
  bool going_on(const BestIterate<Problem>& iterate, Index n_sweeps) const {
    return !iterate.converged() && n_sweeps < stop.max_sweeps && !iterate.out_of_time();
  }

  // ADMM from the best iterate, where W is stored and the law is rigid. It finds states of sliding contacts
  // that Newton's method goes round about.
  template <class Problem>
  void alternate_directions(const Problem& problem, Eigen::VectorXd& r, BestIterate<Problem>& iterate,
                            Index most, Index& n_sweeps) const {
    if constexpr (!Problem::LocalLaw::is_compliant && requires { problem.delassus.n_stored(); }) {
      Admm admm{.stop = stop};
      admm.stop.max_sweeps = std::min(most, stop.max_sweeps - n_sweeps);
      admm.stop.time_limit = stop.time_limit - iterate.report(0).seconds;
      r = iterate.best();
      n_sweeps += admm.solve(problem, r).sweeps;
      iterate.judge(r);
    }
  }

  // Gauss–Seidel from the best iterate until the residual's rate promises to want more sweeps than `limit`
  // and than what comes instead costs, price(); with a small part of the way left, where rates mislead, at
  // least half the price is spent.
  template <class Problem, class Price>
  void sweep_while_promising(const Problem& problem, Eigen::VectorXd& r, BestIterate<Problem>& iterate,
                             Index limit, Index& n_sweeps, const Price& price) const {
    r = iterate.best();
    GaussSeidelSweeps<Problem> sweeps(problem, r);
    double last = iterate.value();
    double residual_of_change = 0;  // what the residual was at the last test over the change of a sweep then
    for (Index done = 0, batch = 5; going_on(iterate, n_sweeps);) {
      batch = std::min(batch, stop.max_sweeps - n_sweeps);
      Index made = 0;
      double change = 0;
      bool early = false;  // a test costs about a sweep, but the change of a sweep tells when the end is near
      for (; made < batch && !early; ++made) {
        change = std::sqrt(sweeps.sweep(r));
        if (residual_of_change == 0 && change > 0) residual_of_change = last / change;
        early = change > 0 && residual_of_change * change <= stop.tolerance;
      }
      n_sweeps += made;
      done += made;
      const double now = iterate.judge(r);
      if (change > 0) residual_of_change = now / change;
      sweeps.restart(r);
      const double rate = std::log(last / now) / static_cast<double>(made);
      const double wanted = std::log(now / stop.tolerance);
      const double promised = static_cast<double>(done) + wanted / std::max(rate, 1e-30);
      if (!early && done >= 20 && promised > static_cast<double>(limit) &&
          promised > static_cast<double>(price()) && (now > 10 * stop.tolerance || 2 * done >= price()))
        return;
      last = now;
      // The next test when it is due by the rate, between 5 and 20 % of the sweeps done.
      const double due = rate > 0 ? wanted / rate : 1e9;
      batch = std::max<Index>(5, static_cast<Index>(std::min(due, 0.2 * static_cast<double>(done))));
    }
  }
};

}  // namespace jampack
