// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <jampack/core/error.hpp>
#include <jampack/law/contact_law.hpp>

namespace jampack {

/// One contact with a force law between the bodies: the reaction r_N (an impulse over a step h) presses them
/// by delta(r_N), so the velocity that the unilateral condition sees is u_N + c(r_N),
/// c(r) = delta(r)/h = coefficient r^exponent. The free velocity q_N must contain gap/h (negative gap:
/// overlap of the undeformed bodies), so that delta is the approach at the end of the step.
struct CompliantContact {
  double coefficient = 0;  ///< velocity per impulse^exponent, >= 0
  double exponent = 1;     ///< 2/3 for spheres, 1 for disks
  double friction = 0;     ///< Coulomb's coefficient on top, >= 0

  static constexpr bool is_compliant = true;
  double compliance(double r) const {
    if (r <= 0) return 0;
    return exponent == 1 ? coefficient * r : coefficient * std::pow(r, exponent);
  }
  double compliance_slope(double r) const {
    return exponent == 1 ? coefficient : coefficient * exponent * std::pow(r, exponent - 1);
  }
};

/// The analytic force law between elastic grains, solved implicitly with the dynamics: the cheap small-strain
/// model, and the oracle an FEM packing is compared with contact by contact.
///   spheres   f = (4/3) E_c sqrt(R_c) delta^(3/2)          (Hertz),
///   disks     f = stiffness_2d E* delta per unit length    (the linear contact of the 2D law),
/// 1/E_c = sum (1 - nu_i^2)/E_i over the two bodies and 1/R_c = sum 1/R_i. E* = E/(2(1 - nu^2)) is E_c of two
/// equal grains. Frictionless, one unknown a contact; `HertzCheckCoulomb` adds friction.
struct HertzCheck {
  double young = 1;         ///< grains' Young modulus, > 0
  double poisson = 0.495;   ///< grains' Poisson ratio, in (-1, 0.5]
  double stiffness_2d = 1;  ///< k of the disks' law, > 0

  using Contact = CompliantContact;
  static constexpr int n_unknowns(int /*dim*/) { return 1; }

  /// E_c of two equal grains, E* = E / (2 (1 - nu^2)).
  double modulus_of_two_grains() const { return young / (2 * (1 - poisson * poisson)); }
  /// E_c of a grain on a rigid wall.
  double modulus_at_wall() const { return young / (1 - poisson * poisson); }

  /// Force at approach delta (0 where delta <= 0). radius is R_c, modulus E_c (2D: E_c plays the part of E*).
  template <int Dim>
  double force(double modulus, double radius, double delta) const {
    if (delta <= 0) return 0;
    if constexpr (Dim == 2)
      return stiffness_2d * modulus * delta;
    else
      return 4.0 / 3 * modulus * std::sqrt(radius) * delta * std::sqrt(delta);
  }

  /// The contact's part of a problem whose reactions are impulses over the time step h.
  template <int Dim>
  CompliantContact contact(double modulus, double radius, double h, double friction = 0) const {
    require(modulus > 0 && radius > 0 && h > 0, "HertzCheck: modulus, radius and time step must be > 0");
    if constexpr (Dim == 2) return {1 / (stiffness_2d * modulus * h * h), 1, friction};
    // delta = (r / (h k))^(2/3) with k = (4/3) E_c sqrt(R_c).
    const double stiffness = 4.0 / 3 * modulus * std::sqrt(radius);
    return {std::pow(h * stiffness, -2.0 / 3) / h, 2.0 / 3, friction};
  }
};

/// HertzCheck in the normal direction with Coulomb friction on top; one unknown a dimension.
struct HertzCheckCoulomb : HertzCheck {
  double friction = 0;  ///< Coulomb's coefficient, >= 0
  static constexpr int n_unknowns(int dim) { return dim; }
};

static_assert(ContactLaw<HertzCheck> && ContactLaw<HertzCheckCoulomb>);

}  // namespace jampack
