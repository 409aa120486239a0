// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <jampack/core/array.hpp>

namespace jampack {

/// Generalised minimal residual method, preconditioned from the right so that the residual it watches is
/// the true one (Saad and Schultz, SIAM J. Sci. Stat. Comput. 7, 1986).
struct Gmres {
  double tolerance = 1e-2;  ///< on |b - A x| / |b|
  Index max_iterations = 100;

  struct Report {
    bool converged = false;
    Index iterations = 0;
    double residual = 0;  ///< relative, as the recurrence has it
  };

  /// Solves A x = b from x = 0. `apply(x, y)` sets y = A x; `precondition(r, z)` sets z close to A^-1 r.
  template <class Apply, class Precondition>
  Report solve(const Apply& apply, const Precondition& precondition, const Eigen::VectorXd& b,
               Eigen::VectorXd& x) const {
    const Eigen::Index n = b.size();
    Report report;
    x.setZero(n);
    const double scale = b.norm();
    if (!(scale > 0)) {
      report.converged = scale == 0;
      return report;
    }
    Array<Eigen::VectorXd> basis{b / scale};
    const auto m = max_iterations;
    Eigen::MatrixXd hessenberg = Eigen::MatrixXd::Zero(m + 1, m);
    Eigen::VectorXd rhs = Eigen::VectorXd::Zero(m + 1);
    rhs[0] = scale;
    Array<Eigen::JacobiRotation<double>> rotations;
    Eigen::VectorXd z(n), w(n);
    Index k = 0;
    for (; k < m; ++k) {
      precondition(basis[k], z);
      apply(z, w);
      for (Index i = 0; i <= k; ++i) {
        hessenberg(i, k) = basis[i].dot(w);
        w -= hessenberg(i, k) * basis[i];
      }
      const double length = w.norm();
      hessenberg(k + 1, k) = length;
      auto column = hessenberg.col(k);
      for (Index i = 0; i < k; ++i) column.applyOnTheLeft(i, i + 1, rotations[i].adjoint());
      Eigen::JacobiRotation<double> rotation;
      rotation.makeGivens(column[k], column[k + 1]);
      rotations.push_back(rotation);
      column.applyOnTheLeft(k, k + 1, rotation.adjoint());
      rhs.applyOnTheLeft(k, k + 1, rotation.adjoint());
      report.residual = std::abs(rhs[k + 1]) / scale;
      if (!(report.residual > tolerance) || !(length > 0)) {
        ++k;
        break;
      }
      basis.push_back(w / length);
    }
    const Eigen::VectorXd y =
        hessenberg.topLeftCorner(k, k).triangularView<Eigen::Upper>().solve(rhs.head(k));
    w.setZero();
    for (Index i = 0; i < k; ++i) w += y[i] * basis[i];
    precondition(w, x);
    report.iterations = k;
    report.converged = report.residual <= tolerance;
    return report;
  }
};

}  // namespace jampack
