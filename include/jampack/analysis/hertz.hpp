// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <jampack/analysis/elastic_moduli.hpp>
#include <jampack/core/error.hpp>
#include <numbers>

namespace jampack {

/// Elastic properties and size of one sphere in a Hertz contact.
struct HertzSphere {
  double diameter;  ///< > 0
  double young;     ///< > 0
  double poisson;   ///< in (-1, 0.5]
};

/// Hertz contact of two smooth frictionless elastic solids of revolution, the limit of small strain.
/// Everything is a function of the approach delta at this one contact; there is no force for delta <= 0.
/// K. L. Johnson, Contact Mechanics (1985), section 4.2; docs/theory/compaction_laws.md (12).
struct HertzContact {
  double modulus;  ///< E_c, 1/E_c = sum of (1 - nu_i^2) / E_i
  double radius;   ///< R_c, 1/R_c = sum of 1 / R_i

  /// f = (4/3) E_c sqrt(R_c) delta^(3/2).
  double force(double delta) const {
    return delta > 0 ? 4.0 / 3.0 * modulus * delta * std::sqrt(radius * delta) : 0.0;
  }
  /// df/ddelta = 2 E_c a.
  double stiffness(double delta) const { return 2 * modulus * contact_radius(delta); }
  /// Approach that carries a force f >= 0; throws InvalidInput for a negative or not finite one.
  double approach(double f) const {
    require(f >= 0 && std::isfinite(f), "HertzContact: the force must be finite and not negative");
    return std::cbrt(std::pow(3 * f / (4 * modulus), 2) / radius);
  }
  /// a = sqrt(R_c delta).
  double contact_radius(double delta) const { return delta > 0 ? std::sqrt(radius * delta) : 0.0; }
  /// p0 = 3 f / (2 pi a^2) = (2/pi) E_c sqrt(delta / R_c).
  double peak_pressure(double delta) const {
    return delta > 0 ? 2 / std::numbers::pi * modulus * std::sqrt(delta / radius) : 0.0;
  }
};

/// Two spheres touching. For two equal ones f = (2/3) E* sqrt(d) delta^(3/2). Throws InvalidInput for
/// impossible properties.
inline HertzContact hertz_two_spheres(const HertzSphere& first, const HertzSphere& second) {
  require(first.diameter > 0 && second.diameter > 0 && std::isfinite(first.diameter) &&
              std::isfinite(second.diameter),
          "hertz_two_spheres: diameters must be positive and finite");
  const double compliance = 1 / half_space_modulus(first.young, first.poisson) +
                            1 / half_space_modulus(second.young, second.poisson);
  return {1 / compliance, 0.5 / (1 / first.diameter + 1 / second.diameter)};
}

/// A sphere on a rigid plane: f/d^2 = (2^(3/2)/3) E / (1 - nu^2) (delta/d)^(3/2). Paper label
/// Hert_wall_sphere, corrected: delta is the approach at one contact. Between two plates the travel of the
/// platen is shared by two contacts, and in it the prefactor is 1/3. Throws InvalidInput for impossible
/// properties.
inline HertzContact hertz_sphere_on_plane(const HertzSphere& sphere) {
  require(sphere.diameter > 0 && std::isfinite(sphere.diameter),
          "hertz_sphere_on_plane: the diameter must be positive and finite");
  return {half_space_modulus(sphere.young, sphere.poisson), sphere.diameter / 2};
}

}  // namespace jampack
