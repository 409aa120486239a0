// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <jampack/core/dimension.hpp>
#include <numbers>

namespace jampack {

/// The part of all directions, in (-1/2, 1/2], under which the origin sees a segment (2D) or a triangle (3D);
/// positive when the corners run as those of a boundary face seen from inside. Over a closed surface the
/// parts add up to how often it winds about the origin (A. Van Oosterom, J. Strackee, "The solid angle of a
/// plane triangle", 1983).
template <int Dim>
double solid_angle(const std::array<Vector<Dim>, Dim>& corner) {
  if constexpr (Dim == 2) {
    const auto& [a, b] = corner;
    return std::atan2(a[0] * b[1] - a[1] * b[0], a.dot(b)) / (2 * std::numbers::pi);
  } else {
    const auto& [a, b, c] = corner;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    return std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb) /
           (2 * std::numbers::pi);
  }
}

}  // namespace jampack
