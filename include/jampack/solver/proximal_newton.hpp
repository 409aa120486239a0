// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <jampack/solver/ball_newton_matrix.hpp>
#include <jampack/solver/contact_solver.hpp>
#include <jampack/solver/grain_newton_matrix.hpp>
#include <jampack/solver/regularised_problem.hpp>
#include <utility>

namespace jampack {

/// Proximal point method over a semismooth Newton method: the problem is solved with W + alpha D around the
/// last solution again and again, so that a singular W (redundant contacts) does no harm and the fixed point
/// is unchanged; alpha falls while Newton's method is at ease and grows when it is not
/// (docs/theory/contact_solvers.md, section 5). A trial step is projected on the cones and smoothed by sweeps
/// before it is judged; where no step length helps, sweeps find other contact states.
struct ProximalNewton {
  StoppingCriterion stop{.max_sweeps = 4000};  ///< max_sweeps: Newton iterations altogether
  double regularisation = 1e-3;                ///< alpha of the first proximal step, relative to 1/rho, > 0
  Index first_sweeps = 20;                     ///< Gauss–Seidel sweeps before the first step
  Index max_rounds = 1;                        ///< of so many, while each brings the residual to 0.8
  Index max_newton = 20;                       ///< Newton iterations in one proximal step
  Index max_failures = 3;                      ///< line searches that may fail in one proximal step
  Index smoothing = 2;                         ///< sweeps after each trial step
  Index recovery = 20;                         ///< sweeps where no step length is accepted
  Threads threads{};                           ///< used between deformable grains only

  template <class Problem>
  SolveReport solve(const Problem& problem, Eigen::VectorXd& r) const {
    require(regularisation > 0, "proximal Newton: the regularisation must be > 0");
    BestIterate<Problem> iterate(problem, stop, r);
    Index n_newton = 0;
    if (!iterate.converged() && problem.n_contacts() > 0) {
      using Matrix = NewtonMatrix<typename Problem::DelassusType>;
      const typename Matrix::Stored& w = Matrix::stored(problem.delassus);
      RegularisedProblem<Matrix, typename Problem::LawType::Contact> step(
          w, problem.free_velocity, problem.law, iterate.rho(), threads);
      step.regularise(0, r);
      for (Index round = 0; round < max_rounds && !iterate.converged(); ++round) {
        const double before = iterate.value();
        step.sweep(r, first_sweeps);
        if (!(iterate.judge(r) < 0.8 * before)) break;
      }
      Workspace work(r.size());
      double alpha = regularisation;
      while (!iterate.converged() && n_newton < stop.max_sweeps && !iterate.out_of_time()) {
        step.regularise(alpha, r);
        const Ease ease = proximal_step(step, iterate.scaled(), r, work, n_newton);
        iterate.judge(r);
        alpha = std::clamp(alpha * change(ease), 1e-10, 10.0);
      }
      r = iterate.best();
    }
    return iterate.report(n_newton);
  }

 private:
  enum class Ease { quick, slow, with_failures, failed };

  struct Workspace {
    explicit Workspace(Index n) : u(n), trial(n), trial_u(n), dr(n) {}
    Eigen::VectorXd u, trial, trial_u, dr;
  };

  static double change(Ease ease) {
    switch (ease) {
      case Ease::quick:
        return 0.1;
      case Ease::slow:
        return 0.5;
      case Ease::with_failures:
        return 1;
      default:
        return 4;
    }
  }

  // Solves one regularised problem to a tenth of the present residual.
  template <class Step>
  Ease proximal_step(Step& step, double residual, Eigen::VectorXd& r, Workspace& work,
                     Index& n_newton) const {
    step.velocity(r, work.u);
    double error = step.error(r, work.u);
    const double target = std::max(0.1 * residual, 1e-15) * r.norm();
    Index failures = 0;
    for (Index k = 0; k < max_newton; ++k) {
      if (k > 0 && error <= target)
        return failures > 0 ? Ease::with_failures : k <= 6 ? Ease::quick : Ease::slow;
      if (failures >= max_failures) return Ease::failed;
      ++n_newton;
      if (step.newton_step(r, work.u, work.dr) && search(step, r, work, error)) continue;
      ++failures;
      step.sweep(r, recovery);
      step.velocity(r, work.u);
      error = step.error(r, work.u);
    }
    return error <= target && failures == 0 ? Ease::slow : Ease::failed;
  }

  // Halves the step until the smoothed trial point is better.
  template <class Step>
  bool search(Step& step, Eigen::VectorXd& r, Workspace& work, double& error) const {
    for (double length = 1; length > 0.05; length *= 0.5) {
      work.trial = r + length * work.dr;
      step.project(work.trial);
      step.sweep(work.trial, smoothing);
      step.velocity(work.trial, work.trial_u);
      const double trial_error = step.error(work.trial, work.trial_u);
      if (!(trial_error < (1 - 0.1 * length) * error)) continue;
      std::swap(r, work.trial);
      std::swap(work.u, work.trial_u);
      error = trial_error;
      return true;
    }
    return false;
  }
};

}  // namespace jampack
