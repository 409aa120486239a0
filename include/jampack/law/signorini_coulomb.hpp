// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/law/contact_law.hpp>

namespace jampack {

/// Rigid contact with Coulomb friction, not regularised: Signorini's condition on the normal components;
/// |r_T| <= friction r_N, and where the contact slips r_T = -friction r_N u_T / |u_T|.
/// One unknown a dimension.
struct SignoriniCoulomb {
  double friction = 0;  ///< Coulomb's coefficient, dimensionless, >= 0

  using Contact = SignoriniCoulomb;
  static constexpr bool is_compliant = false;
  static constexpr int n_unknowns(int dim) { return dim; }
  static constexpr double compliance(double) { return 0; }
  static constexpr double compliance_slope(double) { return 0; }
};

static_assert(ContactLaw<SignoriniCoulomb>);

}  // namespace jampack
