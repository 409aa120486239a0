// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <jampack/core/dimension.hpp>

namespace jampack {

/// Nine colours from dark violet to yellow, evenly spaced in lightness and readable without colour vision
/// (the control points of matplotlib's viridis, CC0). Red, green, blue in [0, 1].
inline constexpr std::array<std::array<double, 3>, 9> viridis_points = {{{0.267, 0.005, 0.329},
                                                                         {0.283, 0.141, 0.458},
                                                                         {0.230, 0.322, 0.546},
                                                                         {0.173, 0.449, 0.558},
                                                                         {0.128, 0.567, 0.551},
                                                                         {0.158, 0.684, 0.502},
                                                                         {0.369, 0.789, 0.383},
                                                                         {0.678, 0.864, 0.190},
                                                                         {0.993, 0.906, 0.144}}};

/// The colour at a place in [0, 1]; places outside, and NaN, take the nearest (the first) colour.
inline Vector<3> viridis(double place) {
  const double scaled = place > 0 ? std::min(place, 1.0) * (viridis_points.size() - 1) : 0.0;
  const auto below = std::min(static_cast<std::size_t>(scaled), viridis_points.size() - 2);
  const double part = scaled - static_cast<double>(below);
  Vector<3> colour;
  for (int c = 0; c < 3; ++c) {
    const auto channel = static_cast<std::size_t>(c);
    colour[c] = (1 - part) * viridis_points[below][channel] + part * viridis_points[below + 1][channel];
  }
  return colour;
}

}  // namespace jampack
