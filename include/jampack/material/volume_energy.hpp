// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <jampack/material/material.hpp>

namespace jampack {

/// Volumetric energy (lambda / 2) ln^2 J: infinite as J -> 0, softening for J > e.
struct LogarithmicVolume {
  static VolumetricResponse response(double lame, double dilatation) {
    const double log = std::log(dilatation);
    return {0.5 * lame * log * log, lame * log / dilatation, lame * (1 - log) / (dilatation * dilatation)};
  }
};

/// Volumetric energy (lambda / 2) (J - 1)^2: convex, finite at J = 0.
struct QuadraticVolume {
  static VolumetricResponse response(double lame, double dilatation) {
    const double change = dilatation - 1;
    return {0.5 * lame * change * change, lame * change, lame};
  }
};

}  // namespace jampack
