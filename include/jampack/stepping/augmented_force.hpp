// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/core/dimension.hpp>

namespace jampack {

/// A contact force by the augmented Lagrangian, P(lambda - rho s), in global axes
/// (docs/theory/deformable_stage.md, eq. 6).
template <int Dim>
struct AugmentedForce {
  Vector<Dim> force = Vector<Dim>::Zero();
  bool open = true;

  /// Of multiplier and displacement in the step, friction >= 0 and penalty rho > 0.
  AugmentedForce(const Vector<Dim>& multiplier, const Vector<Dim>& displacement, const Vector<Dim>& normal,
                 double friction, double rho) {
    const Vector<Dim> trial = multiplier - rho * displacement;
    const double pressing = normal.dot(trial);
    if (!(pressing > 0)) return;
    open = false;
    const Vector<Dim> tangential = trial - pressing * normal;
    const double length = tangential.norm(), bound = friction * pressing;
    force = pressing * normal + (length <= bound ? 1.0 : bound / length) * tangential;
  }
};

}  // namespace jampack
