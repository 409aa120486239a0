// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <numbers>

namespace jampack {

/// The two dimensions jampack is written for: disks (plane strain, unit depth) and spheres.
template <int Dim>
concept SupportedDimension = (Dim == 2 || Dim == 3);

template <int Dim>
using Vector = Eigen::Matrix<double, Dim, 1>;

template <int Dim>
using Matrix = Eigen::Matrix<double, Dim, Dim>;

/// Spin: a scalar in 2D (counter-clockwise), a vector in 3D.
template <int Dim>
using Spin = Eigen::Matrix<double, Dim == 2 ? 1 : 3, 1>;

/// Volume of a ball of the given diameter (area of a disk in 2D).
template <int Dim>
constexpr double ball_volume(double diameter) {
  if constexpr (Dim == 2) return std::numbers::pi / 4 * diameter * diameter;
  return std::numbers::pi / 6 * diameter * diameter * diameter;
}

}  // namespace jampack
