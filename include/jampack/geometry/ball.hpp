// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <jampack/core/array.hpp>
#include <jampack/core/dimension.hpp>
#include <jampack/core/error.hpp>
#include <jampack/geometry/orientation.hpp>
#include <string>

namespace jampack {

/// Balls (disks in 2D): where they are and how they are turned; nothing of mass or motion.
template <int Dim>
requires SupportedDimension<Dim>
struct Balls {
  Array<double> diameter;               ///< > 0, length
  Array<Vector<Dim>> position;          ///< centres, length
  Array<Orientation<Dim>> orientation;  ///< unit quaternion (3D), angle in radians (2D)

  Index size() const { return diameter.size(); }

  /// Adds one ball in its reference orientation; returns its index.
  Index add(double ball_diameter, const Vector<Dim>& centre) {
    diameter.push_back(ball_diameter);
    position.push_back(centre);
    orientation.push_back(no_rotation<Dim>());
    return size() - 1;
  }

  /// Sum of the volumes (areas in 2D) of the true balls.
  double volume() const {
    double sum = 0.0;
    for (const double d : diameter) sum += ball_volume<Dim>(d);
    return sum;
  }

  /// <d>, the length that makes results free of units; there must be a ball.
  double mean_diameter() const {
    double sum = 0.0;
    for (const double d : diameter) sum += d;
    return sum / static_cast<double>(size());
  }
};

/// Refuses what no computation could use: no ball, arrays of unequal length, a diameter that is not
/// positive, a position that is not finite. Throws InvalidInput naming the first offender.
template <int Dim>
void require_usable(const Balls<Dim>& balls) {
  require(balls.size() > 0, "balls: there must be at least one grain, got zero");
  require(balls.position.size() == balls.size() && balls.orientation.size() == balls.size(),
          "balls: diameter, position and orientation must have the same length");
  for (Index i = 0; i < balls.size(); ++i) {
    require(std::isfinite(balls.diameter[i]) && balls.diameter[i] > 0,
            "balls: the diameter of ball " + std::to_string(i) + " must be positive and finite, got " +
                std::to_string(balls.diameter[i]));
    require(balls.position[i].allFinite(),
            "balls: the position of ball " + std::to_string(i) + " is not finite");
  }
}

}  // namespace jampack
