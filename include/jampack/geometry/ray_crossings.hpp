// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <jampack/core/array.hpp>
#include <jampack/geometry/frame.hpp>

namespace jampack {

/// Counts how often a ray leaves a closed surface of segments (2D) or triangles (3D), less how often it
/// enters: how often the surface winds about the origin of the ray.
template <int Dim>
class RayCrossings {
 public:
  /// Corners nearer to the ray than `round_off` (length) make the count uncertain.
  RayCrossings(const Vector<Dim>& origin, const Vector<Dim>& direction, double round_off)
      : origin_(origin), frame_(contact_frame<Dim>(direction)), round_off_(round_off) {}

  /// Distance along the ray, then across it.
  Vector<Dim> seen(const Vector<Dim>& x) const { return frame_ * (x - origin_); }

  /// May the ray pass through this ball?
  bool may_hit(const Vector<Dim>& centre, double radius) const {
    const Vector<Dim> apart = centre - origin_;
    const double along = frame_.row(0).dot(apart);
    return along > -radius && apart.squaredNorm() - along * along < radius * radius;
  }

  /// Counts a piece of the surface, its corners as seen() from the ray and, seen from outside the surface, in
  /// the order of boundary faces.
  void add(const std::array<Vector<Dim>, Dim>& corner) {
    if constexpr (Dim == 2) {
      const auto& [a, b] = corner;
      count(std::array{b[1], -a[1]}, std::array{a[0], b[0]}, round_off_);
    } else {
      const auto& [a, b, c] = corner;
      const auto area = [](const Vector<3>& p, const Vector<3>& q) { return p[1] * q[2] - p[2] * q[1]; };
      double size = 0;
      for (const auto& p : corner) size = std::max({size, std::abs(p[1]), std::abs(p[2])});
      count(std::array{area(b, c), area(c, a), area(a, b)}, std::array{a[0], b[0], c[0]}, round_off_ * size);
    }
  }

  Index count() const { return count_; }
  /// False where the ray passes through a corner or a side, or starts on the surface.
  bool is_certain() const { return is_certain_; }

 private:
  /// The ray passes where weights of all corners have one sign, at their mean height.
  void count(const std::array<double, Dim>& weight, const std::array<double, Dim>& height, double round_off) {
    bool above = true, below = true;
    double least = std::abs(weight[0]), sum = 0, at = 0;
    for (std::size_t i = 0; i < Dim; ++i) {
      above = above && weight[i] > -round_off;
      below = below && weight[i] < round_off;
      least = std::min(least, std::abs(weight[i]));
      sum += weight[i];
      at += weight[i] * height[i];
    }
    if (!above && !below) return;
    if (least <= round_off || std::abs(at) <= round_off_ * std::abs(sum)) {
      is_certain_ = false;
      return;
    }
    if (at / sum > 0) count_ += above ? 1 : -1;
  }

  Vector<Dim> origin_;
  Matrix<Dim> frame_;
  double round_off_;
  Index count_ = 0;
  bool is_certain_ = true;
};

}  // namespace jampack
