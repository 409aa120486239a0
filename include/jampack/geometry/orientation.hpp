// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <jampack/core/dimension.hpp>
#include <type_traits>

namespace jampack {

/// How a body is turned: a unit quaternion in 3D, a counter-clockwise angle (radians, not wrapped) in 2D.
template <int Dim>
using Orientation = std::conditional_t<Dim == 2, double, Eigen::Quaterniond>;

/// The orientation of the reference configuration.
template <int Dim>
Orientation<Dim> no_rotation() {
  if constexpr (Dim == 2)
    return 0.0;
  else
    return Eigen::Quaterniond::Identity();
}

/// The rotation R of an orientation: current = R reference.
template <int Dim>
Matrix<Dim> rotation_matrix(const Orientation<Dim>& orientation) {
  if constexpr (Dim == 2)
    return Eigen::Rotation2Dd(orientation).toRotationMatrix();
  else
    return orientation.toRotationMatrix();
}

/// `orientation` turned further by the rotation vector `turn` (radians, global axes), exactly: the
/// exponential map, so that a constant spin is followed without error whatever the step.
template <int Dim>
Orientation<Dim> turned(const Orientation<Dim>& orientation, const Spin<Dim>& turn) {
  if constexpr (Dim == 2) {
    return orientation + turn[0];
  } else {
    const double angle = turn.norm();
    const double half = 0.5 * angle;
    // sin(a/2)/a, by its series where the quotient would lose digits
    const double scale = angle > 1e-4 ? std::sin(half) / angle : 0.5 - angle * angle / 48.0;
    const Eigen::Quaterniond step(std::cos(half), scale * turn[0], scale * turn[1], scale * turn[2]);
    return (step * orientation).normalized();
  }
}

/// Velocity of a point of a body that spins: spin x lever (in 2D the spin is along the third axis).
template <int Dim>
Vector<Dim> spin_cross(const Spin<Dim>& spin, const Vector<Dim>& lever) {
  if constexpr (Dim == 2)
    return {-spin[0] * lever[1], spin[0] * lever[0]};
  else
    return spin.cross(lever);
}

/// Moment of a force about the body's centre: lever x force (a scalar in 2D).
template <int Dim>
Spin<Dim> moment(const Vector<Dim>& lever, const Vector<Dim>& force) {
  if constexpr (Dim == 2)
    return Spin<2>(lever[0] * force[1] - lever[1] * force[0]);
  else
    return lever.cross(force);
}

}  // namespace jampack
