// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <jampack/law/friction_cone.hpp>

namespace jampack {

/// Sticking reactions of one contact whose block W is singular or nearly so: the points of the friction cone
/// on the affine set W r = -b, for each rank that W may be said to have in floating point.
template <int N>
class StickingSet {
  static_assert(N == 2 || N == 3);
  using Matrix = Eigen::Matrix<double, N, N>;
  using Reaction = ContactVector<N>;

 public:
  /// W = U S V^T of a block that is not zero.
  explicit StickingSet(const Matrix& w) : decomposition_(w, Eigen::ComputeFullU | Eigen::ComputeFullV) {}

  /// The point nearest to sticking for each rank from N down to 1, as close to `guess` as a closed form gives
  /// it: visit(reaction) returns true to stop. Ranks are tried while what they drop could be rounding.
  template <class Visit>
  void for_each_rank(double friction, const Reaction& b, const Reaction& guess, Visit visit) const {
    const Reaction values = decomposition_.singularValues();
    const Matrix& v = decomposition_.matrixV();
    const Reaction load = decomposition_.matrixU().transpose() * b;
    for (int rank = N; rank >= 1; --rank) {
      if (rank < N && values[rank] > 1e-6 * values[0]) return;
      if (!(values[rank - 1] > 1e-15 * values[0])) continue;
      Reaction fixed = Reaction::Zero();
      for (int i = 0; i < rank; ++i) fixed -= load[i] / values[i] * v.col(i);
      Reaction nearest = fixed;
      for (int i = rank; i < N; ++i) nearest += v.col(i).dot(guess) * v.col(i);
      if (!nearest.allFinite()) continue;
      if (rank < N && !in_friction_cone<N>(nearest, friction))
        nearest = N - rank == 1 ? enter(friction, fixed, v.col(N - 1), v.col(N - 1).dot(guess))
                                : on_plane(friction, fixed, nearest, v.col(0));
      if (visit(nearest)) return;
    }
  }

 private:
  // Point of the cone on the line start + s direction, s nearest to `wanted`; where the line misses the cone,
  // its point nearest to it.
  static Reaction enter(double friction, const Reaction& start, const Reaction& direction, double wanted) {
    const auto tangential = start.template tail<N - 1>();
    const auto along = direction.template tail<N - 1>();
    const double m = friction * friction;
    const double a = along.squaredNorm() - m * direction[0] * direction[0];
    const double half_b = tangential.dot(along) - m * start[0] * direction[0];
    const double c = tangential.squaredNorm() - m * start[0] * start[0];
    std::array<double, 3> roots{};
    int n = 0;
    const double discriminant = half_b * half_b - a * c;
    if (discriminant >= 0) {
      const double q = -(half_b + std::copysign(std::sqrt(discriminant), half_b));
      if (a != 0) roots[static_cast<std::size_t>(n++)] = q / a;
      if (q != 0) roots[static_cast<std::size_t>(n++)] = c / q;
    }
    if (a != 0) roots[static_cast<std::size_t>(n++)] = -half_b / a;
    Reaction best = start + wanted * direction;
    double distance = 0, least = outside(best, friction);
    for (int i = 0; i < n; ++i) {
      const double s = roots[static_cast<std::size_t>(i)];
      const Reaction r = start + s * direction;
      if (!r.allFinite()) continue;
      const double error = outside(r, friction), round_off = 1e-14 * r.norm();
      const bool both_inside = error <= round_off && least <= round_off;
      if (both_inside ? std::abs(s - wanted) < distance : error < least) {
        best = r;
        distance = std::abs(s - wanted);
        least = error;
      }
    }
    return best;
  }

  // Point of the cone on the plane normal . r = normal . fixed, on the way from `nearest` to the one in the
  // direction of the normal's projection.
  static Reaction on_plane(double friction, const Reaction& fixed, const Reaction& nearest,
                           const Reaction& normal) {
    const double height = normal.dot(fixed);
    const Reaction target =
        project_on_friction_cone<N>(Reaction(std::copysign(1.0, height) * normal), friction);
    const double size2 = target.squaredNorm();
    if (!(size2 > 0)) return nearest;
    const Reaction inside = std::abs(height) / size2 * target, way = inside - nearest;
    Reaction r = enter(friction, nearest, way, 0);
    return outside(r, friction) <= outside(inside, friction) ? r : inside;
  }

  static double outside(const Reaction& r, double friction) {
    return std::max(0.0, r.template tail<N - 1>().norm() - friction * r[0]);
  }

  Eigen::JacobiSVD<Matrix> decomposition_;
};

}  // namespace jampack
