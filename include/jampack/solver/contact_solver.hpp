// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <concepts>
#include <jampack/problem/residual.hpp>
#include <limits>

namespace jampack {

/// What a contact solver tells of its work.
struct SolveReport {
  bool converged = false;
  Index sweeps = 0;     ///< sweeps, or iterations of a method without sweeps
  double residual = 0;  ///< scaled_residual of what was returned, recomputed from W r + q
  double seconds = 0;   ///< wall time, set-up included
};

/// When to stop; every solver carries one.
struct StoppingCriterion {
  double tolerance = 1e-8;                                      ///< on scaled_residual, > 0
  Index max_sweeps = 100000;                                    ///< or iterations
  double time_limit = std::numeric_limits<double>::infinity();  ///< seconds
  /// Stricter: the residual of the literature and scaled_residual taken relative to |r| alone must both
  /// reach the tolerance too.
  bool strict = false;
};

/// A contact solver changes r from its first guess (the warm start) to the best iterate it has met.
template <class S, class Problem>
concept ContactSolver = requires(const S& solver, const Problem& problem, Eigen::VectorXd& r) {
  { solver.solve(problem, r) } -> std::same_as<SolveReport>;
};

/// Wall seconds since it was made.
class Stopwatch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Judges iterates by what a solver stops on, always recomputed from W r + q, and keeps the best of them.
template <class Problem>
class BestIterate {
 public:
  /// Takes the first guess. Throws InvalidInput if it does not fit the problem or the tolerance is not > 0.
  BestIterate(const Problem& problem, const StoppingCriterion& stop, const Eigen::VectorXd& r)
      : problem_(problem), stop_(stop), rho_(natural_map_steps(problem)), best_(r), u_(r.size()) {
    require(r.size() == problem.free_velocity.size() && r.allFinite(),
            "contact solver: the first guess has the wrong size or is not finite");
    require(stop.tolerance > 0, "contact solver: the tolerance must be > 0");
    constexpr int n = Problem::n_unknowns;
    for (Index c = 0; c < problem.n_contacts(); ++c)
      load_ += rho_[c] * rho_[c] * problem.free_velocity.template segment<n>(n * c).squaredNorm();
    load_ = std::sqrt(load_);
    judge(r);
  }

  /// Judges r; returns what must fall below the tolerance.
  double judge(const Eigen::VectorXd& r) {
    contact_velocity(problem_, r, u_);
    const double scaled = scaled_residual(problem_, rho_, r, u_);
    const double now = stop_.strict
                           ? std::max(scaled_residual(problem_, rho_, r, u_, true), residual(problem_, r, u_))
                           : scaled;
    // An infeasible problem lets r grow without end, and any residual relative to |r| fall: beyond a million
    // times what the loads would explain, it is taken relative to the loads.
    // A million times farther out round-off hides what is left: that is no solution.
    const double growth = 1e-6 * r.norm() / std::max(load_, 1e-300);
    const double judged =
        growth < 1e6 || load_ == 0 ? now * std::max(1.0, growth) : std::numeric_limits<double>::infinity();
    if (judged < value_) {
      value_ = judged;
      scaled_ = scaled;
      best_ = r;
    }
    return judged;
  }

  bool converged() const { return value_ <= stop_.tolerance; }
  bool out_of_time() const { return clock_.seconds() >= stop_.time_limit; }
  double value() const { return value_; }
  double scaled() const { return scaled_; }  ///< scaled_residual of the best iterate
  const Eigen::VectorXd& best() const { return best_; }
  const Array<double>& rho() const { return rho_; }
  const Eigen::VectorXd& velocity() const { return u_; }  ///< W r + q of the iterate judged last

  SolveReport report(Index sweeps) const { return {converged(), sweeps, scaled_, clock_.seconds()}; }

 private:
  Stopwatch clock_;
  const Problem& problem_;
  StoppingCriterion stop_;
  Array<double> rho_;
  Eigen::VectorXd best_, u_;
  double load_ = 0;  // |rho q|
  double value_ = std::numeric_limits<double>::infinity(), scaled_ = value_;
};

}  // namespace jampack
