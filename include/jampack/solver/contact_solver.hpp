// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
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
  double tolerance = 1e-8;  ///< on scaled_residual, > 0
  Index max_sweeps = 100000;
  double time_limit = std::numeric_limits<double>::infinity();  ///< seconds
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

}  // namespace jampack
