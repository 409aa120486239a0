// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <jampack/core/error.hpp>

namespace jampack {

/// Mean coordination number of a packing pressed beyond jamming, Z = Z0 + psi sqrt(phi - phi0): paper label
/// eq:ZvsPpi, docs/theory/compaction_laws.md (3).
struct CoordinationLaw {
  double phi0;  ///< packing fraction at jamming, in (0, 1)
  double z0;    ///< coordination number at jamming, >= 0
  double psi;   ///< growth, >= 0

  /// Z at packing fraction phi >= phi0; throws InvalidInput below phi0 or for impossible parameters.
  double operator()(double phi) const {
    require(phi0 > 0 && phi0 < 1 && z0 >= 0 && psi >= 0 && std::isfinite(z0) && std::isfinite(psi),
            "CoordinationLaw: needs phi0 in (0, 1), z0 >= 0 and psi >= 0");
    require(phi >= phi0 && std::isfinite(phi), "CoordinationLaw: phi must be finite and at least phi0");
    return z0 + psi * std::sqrt(phi - phi0);
  }
};

/// The law through jamming and one dense state: psi = (z_dense - z0) / sqrt(phi_dense - phi0). The paper
/// takes the densest, phi_max, and calls Z there "the maximum packing fraction" (corrected: it is the
/// coordination number at phi_max).
inline CoordinationLaw coordination_law_through(double phi0, double z0, double phi_dense, double z_dense) {
  require(phi_dense > phi0 && z_dense >= z0,
          "coordination_law_through: the dense state must have phi above phi0 and Z of at least z0");
  return {phi0, z0, (z_dense - z0) / std::sqrt(phi_dense - phi0)};
}

}  // namespace jampack
