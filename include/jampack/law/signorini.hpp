// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/law/contact_law.hpp>

namespace jampack {

/// Rigid, frictionless contact: 0 <= r_N, u_N >= 0, r_N u_N = 0. One unknown a contact, in 2D and in 3D.
struct Signorini {
  using Contact = Signorini;
  static constexpr bool is_compliant = false;
  static constexpr double friction = 0;
  static constexpr int n_unknowns(int /*dim*/) { return 1; }
  static constexpr double compliance(double) { return 0; }
  static constexpr double compliance_slope(double) { return 0; }
};

static_assert(ContactLaw<Signorini>);

}  // namespace jampack
