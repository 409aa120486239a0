// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <jampack/core/array.hpp>
#include <limits>

namespace jampack {

/// Generalised minimal residuals without restart, preconditioned from the right (Y. Saad and M. H. Schultz,
/// SIAM J. Sci. Stat. Comput. 7 (1986) 856). apply(x, y): y = A x; precondition(x): x becomes about A^-1 x.
/// x, the right-hand side b, becomes the solution. Returns |b - A x| / |b|: at most the tolerance, unless
/// that took more than max_iterations; infinite, with x as it was, where numbers are not finite or A is
/// singular.
template <class Apply, class Precondition>
double gmres(const Apply& apply, const Precondition& precondition, Eigen::VectorXd& x, double tolerance,
             Index max_iterations) {
  const double size = x.norm();
  constexpr double failed = std::numeric_limits<double>::infinity();
  if (size == 0) return 0;
  if (!std::isfinite(size)) return failed;
  Array<Eigen::VectorXd> basis{x / size};
  Array<Eigen::VectorXd> columns;       // of the triangular factor of the Hessenberg matrix
  Array<Eigen::Vector2d> turns;         // cosine and sine of the rotations that made it so
  Array<double> right_hand_side{size};  // turned in the same way; its last entry is the residual
  const auto left = [&] { return std::abs(right_hand_side.back()) / size; };
  for (Index k = 0; k < max_iterations && left() > tolerance; ++k) {
    Eigen::VectorXd direction = basis.back(), next;
    precondition(direction);
    apply(direction, next);
    Eigen::VectorXd column(k + 1);
    for (Index i = 0; i <= k; ++i) {
      column[i] = basis[i].dot(next);
      next -= column[i] * basis[i];
    }
    double below = next.norm();
    if (!std::isfinite(below)) return failed;
    basis.push_back(below > 0 ? Eigen::VectorXd(next / below) : next);
    for (Index i = 0; i < k; ++i) {
      const double upper = turns[i][0] * column[i] + turns[i][1] * column[i + 1];
      column[i + 1] = turns[i][0] * column[i + 1] - turns[i][1] * column[i];
      column[i] = upper;
    }
    const double length = std::hypot(column[k], below);
    if (!(length > 0)) return failed;
    turns.push_back({column[k] / length, below / length});
    column[k] = length;
    columns.push_back(column);
    const double rest = right_hand_side[k];
    right_hand_side[k] = turns[k][0] * rest;
    right_hand_side.push_back(-turns[k][1] * rest);
  }
  const Index m = columns.size();
  Eigen::VectorXd y(m);
  for (Index i = m - 1; i >= 0; --i) {
    double sum = right_hand_side[i];
    for (Index j = i + 1; j < m; ++j) sum -= columns[j][i] * y[j];
    y[i] = sum / columns[i][i];
  }
  x.setZero();
  for (Index i = 0; i < m; ++i) x += y[i] * basis[i];
  precondition(x);
  return left();
}

}  // namespace jampack
