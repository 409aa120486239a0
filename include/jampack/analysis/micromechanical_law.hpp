// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <jampack/analysis/coordination_law.hpp>
#include <jampack/analysis/heckel_secondi_law.hpp>
#include <jampack/analysis/small_strain_law.hpp>
#include <jampack/core/dimension.hpp>
#include <jampack/core/error.hpp>
#include <numbers>

namespace jampack {

/// The closed compaction law P(phi): granular stress, Z(phi) and the contact law, with nothing left to fit
/// but phi_max. P is over E* = E / [2 (1 - nu^2)]; it starts at zero at phi0, increases, and is +infinity at
/// phi_max.
template <int Dim>
requires SupportedDimension<Dim>
struct MicromechanicalLaw;

/// Spheres (Hertz contacts):
///   P/E* = -2 / (3 pi Gamma^(3/2)) (phi_max - phi0) / phi0^(3/2) phi sqrt(phi - phi0)
///          [Z0 + psi sqrt(phi - phi0)] ln[(phi_max - phi) / (phi_max - phi0)].
/// Paper label eq:Pglobal_2, corrected: with the printed -psi the law turns negative near phi = 0.67.
/// docs/theory/compaction_laws.md (8).
template <>
struct MicromechanicalLaw<3> {
  double phi0;     ///< packing fraction at jamming, in (0, phi_max)
  double phi_max;  ///< packing fraction at which the pressure diverges
  double z0;       ///< coordination number at jamming, > 0
  double psi;      ///< growth of Z, >= 0, see CoordinationLaw
  double gamma;    ///< volumetric strain over mean contact strain at small strain, > 0

  /// P/E* for phi in [phi0, phi_max], infinite at phi_max; throws InvalidInput outside or for impossible
  /// parameters.
  double operator()(double phi) const {
    require(gamma > 0, "MicromechanicalLaw: gamma must be positive");
    const double log_term = HeckelSecondiLaw{.phi0 = phi0, .phi_max = phi_max, .amplitude = 1}(phi);
    const double z = coordination()(phi);
    return 2 / (3 * std::numbers::pi * gamma * std::sqrt(gamma)) * (phi_max - phi0) /
           (phi0 * std::sqrt(phi0)) * phi * std::sqrt(phi - phi0) * z * log_term;
  }

  CoordinationLaw coordination() const { return {phi0, z0, psi}; }
  SmallStrainLaw<3> small_strain() const { return {phi0, z0, gamma}; }
};

/// Disks, with a linear contact f = k E* delta (f per unit length):
///   P/E* = -k / (pi Gamma) (phi_max - phi0) / phi0 phi [Z0 + psi sqrt(phi - phi0)]
///          ln[(phi_max - phi) / (phi_max - phi0)].
/// The paper's replacement rule has a bracket slip, corrected: (2/3) sqrt(phi - phi0) / (Gamma phi0)^(3/2)
/// becomes 1 / (Gamma phi0). docs/theory/compaction_laws.md (9).
template <>
struct MicromechanicalLaw<2> {
  double phi0;                   ///< packing fraction at jamming, in (0, phi_max)
  double phi_max;                ///< packing fraction at which the pressure diverges
  double z0;                     ///< coordination number at jamming, > 0
  double psi;                    ///< growth of Z, >= 0, see CoordinationLaw
  double gamma;                  ///< volumetric strain over mean contact strain at small strain, > 0
  double contact_stiffness = 1;  ///< k, > 0: measured, since a line contact is logarithmic, not linear

  /// P/E* for phi in [phi0, phi_max], infinite at phi_max; throws InvalidInput outside or for impossible
  /// parameters.
  double operator()(double phi) const {
    require(gamma > 0 && contact_stiffness > 0,
            "MicromechanicalLaw: gamma and contact_stiffness must be positive");
    const double log_term = HeckelSecondiLaw{.phi0 = phi0, .phi_max = phi_max, .amplitude = 1}(phi);
    const double z = coordination()(phi);
    return contact_stiffness / (std::numbers::pi * gamma) * (phi_max - phi0) / phi0 * phi * z * log_term;
  }

  CoordinationLaw coordination() const { return {phi0, z0, psi}; }
  SmallStrainLaw<2> small_strain() const { return {phi0, z0, gamma, contact_stiffness}; }
};

/// The constants the paper states for its frictional spheres (phi0 is 0.50 for N = 50, 0.51 for N = 100).
inline constexpr MicromechanicalLaw<3> paper_micromechanical_law{
    .phi0 = 0.50, .phi_max = 0.965, .z0 = 3.5, .psi = 8.5, .gamma = 4.4};

}  // namespace jampack
