// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <jampack/core/error.hpp>
#include <limits>

namespace jampack {

/// Heckel-Secondi compaction law, P/E* = -A ln[(phi_max - phi) / (phi_max - phi0)], with E* = E / [2 (1 -
/// nu^2)]: paper label Eq_Heckel, docs/theory/compaction_laws.md (10).
struct HeckelSecondiLaw {
  double phi0;       ///< packing fraction at jamming, in (0, phi_max)
  double phi_max;    ///< packing fraction at which the pressure diverges
  double amplitude;  ///< A, > 0

  /// P/E* for phi in [phi0, phi_max], +infinity at phi_max; throws InvalidInput outside or for impossible
  /// parameters.
  double operator()(double phi) const {
    require(phi0 > 0 && phi_max > phi0 && std::isfinite(phi_max) && amplitude > 0,
            "compaction law: needs 0 < phi0 < phi_max and a positive amplitude");
    require(phi >= phi0 && phi <= phi_max, "compaction law: phi must lie in [phi0, phi_max]");
    if (phi == phi_max) return std::numeric_limits<double>::infinity();
    // log1p keeps the digits of phi - phi0 just beyond jamming.
    return -amplitude * std::log1p(-(phi - phi0) / (phi_max - phi0));
  }
};

/// The constants the paper fits.
inline constexpr HeckelSecondiLaw paper_heckel_secondi_law{.phi0 = 0.50, .phi_max = 0.965, .amplitude = 0.15};

}  // namespace jampack
