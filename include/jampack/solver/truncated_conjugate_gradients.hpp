// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Dense>
#include <jampack/core/array.hpp>

namespace jampack {

/// What truncated conjugate gradients found.
struct TruncatedSolve {
  Index iterations = 0;
  bool negative_curvature = false;
};

/// Preconditioned conjugate gradients for A x = b with A symmetric, that stop where A shows a direction p of
/// negative curvature (p^T A p <= 0): then x is what was reached before, and p, along which the quadratic
/// model falls without end, is written too (T. Steihaug, SIAM J. Numer. Anal. 20 (1983) 626).
struct TruncatedConjugateGradients {
  double tolerance = 0.1;  ///< on |b - A x| / |b|, > 0
  Index max_iterations = 200;

  /// apply(x, y): y = A x; precondition(r, z): z = B r with B symmetric positive definite.
  template <class Apply, class Precondition>
  TruncatedSolve solve(Apply apply, Precondition precondition, const Eigen::VectorXd& b, Eigen::VectorXd& x,
                       Eigen::VectorXd& direction) const {
    TruncatedSolve report;
    x.setZero(b.size());
    Eigen::VectorXd r = b, z(b.size()), image(b.size());
    precondition(r, z);
    direction = z;
    double rz = r.dot(z);
    const double target = tolerance * b.norm();
    while (report.iterations < max_iterations && r.norm() > target) {
      ++report.iterations;
      apply(direction, image);
      const double curvature = direction.dot(image);
      if (!(curvature > 0)) {
        report.negative_curvature = true;
        return report;
      }
      const double length = rz / curvature;
      x += length * direction;
      r -= length * image;
      precondition(r, z);
      const double next = r.dot(z);
      direction = z + next / rz * direction;
      rz = next;
    }
    return report;
  }
};

}  // namespace jampack
