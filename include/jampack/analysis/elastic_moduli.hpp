// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <jampack/core/error.hpp>

namespace jampack {

/// E / (1 - nu^2): the contact modulus of one elastic solid against a rigid one.
/// Throws InvalidInput unless young > 0 and poisson is in (-1, 0.5].
inline double half_space_modulus(double young, double poisson) {
  require(young > 0 && std::isfinite(young), "Young's modulus must be positive and finite");
  require(poisson > -1 && poisson <= 0.5, "Poisson's ratio must lie in (-1, 0.5]");
  return young / (1 - poisson * poisson);
}

/// E* = E / [2 (1 - nu^2)], the contact modulus of two equal solids: what the paper writes "E/2(1-nu^2)" and
/// divides its pressures by. Throws as half_space_modulus.
inline double reduced_modulus(double young, double poisson) {
  return half_space_modulus(young, poisson) / 2;
}

}  // namespace jampack
