// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <jampack/core/array.hpp>
#include <jampack/core/dimension.hpp>
#include <jampack/core/error.hpp>
#include <numbers>

namespace jampack {

/// Sphericity pi^(1/3) (6 V)^(2/3) / a of a body of volume V > 0 and surface area a > 0: 1 for a sphere, less
/// for any other shape. Paper label eq:circu_mix.
inline double sphericity(double volume, double area) {
  require(volume > 0 && area > 0, "sphericity: volume and area must be positive");
  const double root = std::cbrt(6 * volume);
  return std::cbrt(std::numbers::pi) * root * root / area;
}

/// Circularity 4 pi A / p^2 of a figure of area A > 0 and perimeter p > 0: 1 for a disk. This is the form
/// quadratic in the perimeter; near 1 its loss is twice that of its square root.
inline double circularity(double area, double perimeter) {
  require(area > 0 && perimeter > 0, "circularity: area and perimeter must be positive");
  return 4 * std::numbers::pi * area / (perimeter * perimeter);
}

/// Sphericity in 3D, circularity in 2D.
template <int Dim>
requires SupportedDimension<Dim>
double roundness(double volume, double surface) {
  if constexpr (Dim == 2)
    return circularity(volume, surface);
  else
    return sphericity(volume, surface);
}

/// Mean roundness of the grains, each with its current volume and surface; throws InvalidInput when there is
/// none or the lengths differ.
template <int Dim>
double mean_roundness(const Array<double>& volumes, const Array<double>& surfaces) {
  require(!volumes.empty() && volumes.size() == surfaces.size(),
          "mean_roundness: needs one volume and one surface a grain, and at least one grain");
  double sum = 0;
  for (Index i = 0; i < volumes.size(); ++i) sum += roundness<Dim>(volumes[i], surfaces[i]);
  return sum / static_cast<double>(volumes.size());
}

}  // namespace jampack
