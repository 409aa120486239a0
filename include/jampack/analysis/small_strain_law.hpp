// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <jampack/core/dimension.hpp>
#include <jampack/core/error.hpp>
#include <numbers>

namespace jampack {

/// Pressure over E* = E / [2 (1 - nu^2)] of a packing just beyond jamming, where neither Z nor phi in the
/// branch vectors has changed yet. P(phi0) = 0.
template <int Dim>
requires SupportedDimension<Dim>
struct SmallStrainLaw;

/// Spheres: P_SD/E* = + 2 / (3 pi Gamma^(3/2)) Z0 phi ln(phi/phi0)^(3/2). Paper label eq:Pgsd, corrected:
/// as printed the logarithm is negative and its power complex. docs/theory/compaction_laws.md (6).
template <>
struct SmallStrainLaw<3> {
  double phi0;   ///< packing fraction at jamming, in (0, 1)
  double z0;     ///< coordination number at jamming, > 0
  double gamma;  ///< volumetric strain over mean contact strain, > 0 (3 when affine)

  /// P_SD/E* at phi >= phi0; throws InvalidInput below phi0 or for impossible parameters.
  double operator()(double phi) const {
    require(phi0 > 0 && phi0 < 1 && z0 > 0 && gamma > 0,
            "SmallStrainLaw: needs phi0 in (0, 1), z0 > 0 and gamma > 0");
    require(phi >= phi0 && std::isfinite(phi), "SmallStrainLaw: phi must be finite and at least phi0");
    const double contact_strain = std::log1p((phi - phi0) / phi0) / gamma;
    return 2 / (3 * std::numbers::pi) * z0 * phi * contact_strain * std::sqrt(contact_strain);
  }
};

/// Disks with a linear contact f = k E* delta (f per unit length): P_SD/E* = k / (pi Gamma) Z0 phi
/// ln(phi/phi0). docs/theory/compaction_laws.md (7).
template <>
struct SmallStrainLaw<2> {
  double phi0;                   ///< packing fraction at jamming, in (0, 1)
  double z0;                     ///< coordination number at jamming, > 0
  double gamma;                  ///< volumetric strain over mean contact strain, > 0 (2 when affine)
  double contact_stiffness = 1;  ///< k, > 0

  /// P_SD/E* at phi >= phi0; throws InvalidInput below phi0 or for impossible parameters.
  double operator()(double phi) const {
    require(phi0 > 0 && phi0 < 1 && z0 > 0 && gamma > 0 && contact_stiffness > 0,
            "SmallStrainLaw: needs phi0 in (0, 1), z0 > 0, gamma > 0 and contact_stiffness > 0");
    require(phi >= phi0 && std::isfinite(phi), "SmallStrainLaw: phi must be finite and at least phi0");
    const double contact_strain = std::log1p((phi - phi0) / phi0) / gamma;
    return contact_stiffness / std::numbers::pi * z0 * phi * contact_strain;
  }
};

}  // namespace jampack
