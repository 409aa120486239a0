// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/core/array.hpp>
#include <jampack/core/dimension.hpp>
#include <jampack/core/error.hpp>
#include <jampack/geometry/half_space.hpp>
#include <string>

namespace jampack {

/// A rectangular cell of 2 * Dim plane walls. Wall w is normal to axis w / 2; w % 2 is 0 for the lower side
/// and 1 for the upper.
template <int Dim>
requires SupportedDimension<Dim>
struct Box {
  Vector<Dim> lower = Vector<Dim>::Zero();  ///< length
  Vector<Dim> upper = Vector<Dim>::Ones();  ///< length, above `lower` on every axis

  static constexpr int n_walls = 2 * Dim;

  Vector<Dim> lengths() const { return upper - lower; }
  Vector<Dim> centre() const { return 0.5 * (lower + upper); }
  double volume() const { return lengths().prod(); }

  /// Area of a wall (length in 2D).
  double wall_area(Index w) const { return volume() / lengths()[w / 2]; }

  /// Wall w as a half-space, its normal pointing inwards.
  HalfSpace<Dim> wall(Index w) const {
    const Index axis = w / 2;
    Vector<Dim> normal = Vector<Dim>::Zero();
    normal[axis] = w % 2 == 0 ? 1.0 : -1.0;
    return {normal, w % 2 == 0 ? lower[axis] : -upper[axis]};
  }
};

/// A cube (square in 2D) of the given edge, centred at the origin.
template <int Dim>
Box<Dim> centred_cube(double edge) {
  return {Vector<Dim>::Constant(-0.5 * edge), Vector<Dim>::Constant(0.5 * edge)};
}

/// Throws InvalidInput unless the box is finite and open on every axis.
template <int Dim>
void require_usable(const Box<Dim>& box) {
  require(box.lower.allFinite() && box.upper.allFinite(), "box: its corners must be finite");
  require((box.lengths().array() > 0).all(),
          "box: the upper corner must lie above the lower one on every axis");
}

}  // namespace jampack
