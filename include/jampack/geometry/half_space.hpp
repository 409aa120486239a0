// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/core/dimension.hpp>

namespace jampack {

/// The room left by a rigid plane wall: the points x with normal . x >= offset. As an antagonist its
/// `normal` is the contact normal n of geometry/frame.hpp, pointing from the wall into the room.
template <int Dim>
struct HalfSpace {
  Vector<Dim> normal = Vector<Dim>::UnitX();  ///< unit vector
  double offset = 0.0;                        ///< length

  /// Signed distance of a point, positive inside.
  double distance(const Vector<Dim>& point) const { return normal.dot(point) - offset; }
};

/// The half-space through `point` with `direction` (any length but zero) pointing into the room.
template <int Dim>
HalfSpace<Dim> half_space(const Vector<Dim>& direction, const Vector<Dim>& point) {
  const Vector<Dim> normal = direction.normalized();
  return {normal, normal.dot(point)};
}

}  // namespace jampack
