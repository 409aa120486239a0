// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <jampack/core/error.hpp>

namespace jampack {

/// Loss of the mean sphericity beyond jamming, rho0 - rho = A (phi - phi0)^beta. Paper label
/// Eq_shape_phi_3D, corrected: the sphericity falls, so what is positive is rho0 - rho.
/// docs/theory/compaction_laws.md (11).
struct SphericityLaw {
  double phi0;       ///< packing fraction at jamming, in (0, 1)
  double amplitude;  ///< A, >= 0
  double exponent;   ///< beta, > 0

  /// rho0 - rho at packing fraction phi >= phi0; throws InvalidInput below phi0 or for impossible
  /// parameters.
  double operator()(double phi) const {
    require(phi0 > 0 && phi0 < 1 && amplitude >= 0 && exponent > 0,
            "SphericityLaw: needs phi0 in (0, 1), amplitude >= 0 and exponent > 0");
    require(phi >= phi0 && std::isfinite(phi), "SphericityLaw: phi must be finite and at least phi0");
    return amplitude * std::pow(phi - phi0, exponent);
  }
};

/// The constants the paper fits.
inline constexpr SphericityLaw paper_sphericity_law{.phi0 = 0.50, .amplitude = 0.6, .exponent = 2.5};

}  // namespace jampack
