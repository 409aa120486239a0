// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <jampack/core/error.hpp>
#include <string>

namespace jampack {

/// Lame's second parameter G = E / (2 (1 + nu)).
constexpr double shear_modulus(double young, double poisson) {
  return young / (2 * (1 + poisson));
}

/// Lame's first parameter lambda = E nu / ((1 + nu)(1 - 2 nu)).
constexpr double lame_modulus(double young, double poisson) {
  return young * poisson / ((1 + poisson) * (1 - 2 * poisson));
}

/// Bulk modulus kappa = E / (3 (1 - 2 nu)).
constexpr double bulk_modulus(double young, double poisson) {
  return young / (3 * (1 - 2 * poisson));
}

/// Plane-strain modulus E / (1 - nu^2), that of Hertz's law for a grain on a rigid plane.
constexpr double plane_strain_modulus(double young, double poisson) {
  return young / (1 - poisson * poisson);
}

/// The effective modulus E* = E / (2 (1 - nu^2)) of a contact of two equal grains, by which the P(phi) laws
/// divide (docs/theory/elements.md).
constexpr double contact_modulus(double young, double poisson) {
  return plane_strain_modulus(young, poisson) / 2;
}

/// Throws InvalidInput unless young > 0, -1 < poisson < 0.5 and density > 0, all finite.
inline void validate_isotropic(double young, double poisson, double density) {
  const auto check = [](bool good, const char* what, double value) {
    require(good, std::string("material: ") + what + ", not " + std::to_string(value));
  };
  check(std::isfinite(young) && young > 0, "young must be positive and finite", young);
  check(poisson > -1 && poisson < 0.5, "poisson must lie in (-1, 0.5)", poisson);
  check(std::isfinite(density) && density > 0, "density must be positive and finite", density);
}

}  // namespace jampack
