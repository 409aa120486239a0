// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <jampack/core/error.hpp>
#include <jampack/geometry/ball.hpp>
#include <jampack/geometry/box.hpp>
#include <jampack/packing/random.hpp>
#include <string>

namespace jampack {

/// Balls in a box: the state every stage starts from and hands on.
template <int Dim>
struct Packing {
  Balls<Dim> balls;
  Box<Dim> box;

  /// phi of the true balls: their volume over the box's.
  double packing_fraction() const { return balls.volume() / box.volume(); }
};

/// What random_packing should make. Lengths in the unit of `mean_diameter`.
struct RandomPackingOptions {
  Index n_grains = 100;           ///< >= 1
  double mean_diameter = 1.0;     ///< <d> > 0, length
  double polydispersity = 0.2;    ///< d is uniform in [1 - p, 1 + p] <d>, p in [0, 1)
  double packing_fraction = 0.0;  ///< wanted phi in (0, 1); 0 takes 0.25 in 3D and 0.40 in 2D
  std::uint64_t seed = 1;
};

namespace detail {

/// Random sequential addition: tries to place every ball (largest first) where none is; false when a ball
/// found no place in `attempts` trials.
template <int Dim>
bool place_one_by_one(Balls<Dim>& balls, const Box<Dim>& box, RandomSource& random, Index attempts) {
  for (Index i = 0; i < balls.size(); ++i) {
    const double radius = 0.5 * balls.diameter[i];
    if ((box.lengths().array() < balls.diameter[i]).any()) return false;
    bool placed = false;
    for (Index attempt = 0; attempt < attempts && !placed; ++attempt) {
      Vector<Dim> x;
      for (int axis = 0; axis < Dim; ++axis)
        x[axis] = random.uniform(box.lower[axis] + radius, box.upper[axis] - radius);
      placed = true;
      for (Index j = 0; j < i && placed; ++j) {
        const double reach = radius + 0.5 * balls.diameter[j];
        placed = (x - balls.position[j]).squaredNorm() > reach * reach;
      }
      if (placed) balls.position[i] = x;
    }
    if (!placed) return false;
  }
  return true;
}

}  // namespace detail

/// A random loose packing: polydisperse balls, none overlapping another or a wall, in a cubic box centred at
/// the origin, each turned at random. Balls are placed one by one, the largest first (ball 0 is the largest);
/// where they do not fit at the wanted packing fraction it is lowered by 5 % and the placing starts again, so
/// that any number of grains finds its box. Same seed, same packing, on every platform.
/// Throws InvalidInput for options outside their ranges.
template <int Dim>
requires SupportedDimension<Dim> Packing<Dim> random_packing(const RandomPackingOptions& options) {
  require(options.n_grains >= 1,
          "random packing: the number of grains must be at least 1, got " + std::to_string(options.n_grains));
  require(std::isfinite(options.mean_diameter) && options.mean_diameter > 0,
          "random packing: the mean diameter must be positive and finite, got " +
              std::to_string(options.mean_diameter));
  require(
      options.polydispersity >= 0 && options.polydispersity < 1,
      "random packing: the polydispersity must be in [0, 1), got " + std::to_string(options.polydispersity));
  require(options.packing_fraction >= 0 && options.packing_fraction < 1,
          "random packing: the packing fraction must be in (0, 1), or 0 for the default, got " +
              std::to_string(options.packing_fraction));

  RandomSource random(options.seed);
  Packing<Dim> packing;
  Array<double> diameter(options.n_grains);
  // Drawn at unit mean and scaled, so that a change of units is a scaling of the packing.
  for (double& d : diameter) d = random.uniform(1.0 - options.polydispersity, 1.0 + options.polydispersity);
  std::sort(diameter.begin(), diameter.end(), std::greater<>());
  for (const double d : diameter) packing.balls.add(d, Vector<Dim>::Zero());
  for (auto& orientation : packing.balls.orientation) orientation = random.template orientation<Dim>();

  double fraction = options.packing_fraction > 0 ? options.packing_fraction : (Dim == 3 ? 0.25 : 0.40);
  constexpr Index attempts = 2000;
  while (true) {
    packing.box = centred_cube<Dim>(std::pow(packing.balls.volume() / fraction, 1.0 / Dim));
    if (detail::place_one_by_one(packing.balls, packing.box, random, attempts)) break;
    fraction *= 0.95;
  }

  for (double& d : packing.balls.diameter) d *= options.mean_diameter;
  for (auto& x : packing.balls.position) x *= options.mean_diameter;
  packing.box.lower *= options.mean_diameter;
  packing.box.upper *= options.mean_diameter;
  return packing;
}

}  // namespace jampack
