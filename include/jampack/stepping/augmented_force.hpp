// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/core/dimension.hpp>

namespace jampack {

/// A contact force by the augmented Lagrangian, P(lambda - rho s), in global axes, and how it came about
/// (docs/theory/deformable_stage.md, eq. 6 and 7).
template <int Dim>
struct AugmentedForce {
  Vector<Dim> force = Vector<Dim>::Zero();
  bool open = true;
  double held = 1;  ///< 1 where it sticks, else friction bound over |tangential trial| < 1
  Vector<Dim> slip = Vector<Dim>::Zero();  ///< unit direction of the friction force where it slips

  /// Of multiplier and displacement in the step, friction >= 0 and penalty rho > 0.
  AugmentedForce(const Vector<Dim>& multiplier, const Vector<Dim>& displacement, const Vector<Dim>& normal,
                 double friction, double rho) {
    const Vector<Dim> trial = multiplier - rho * displacement;
    const double pressing = normal.dot(trial);
    if (!(pressing > 0)) return;
    open = false;
    const Vector<Dim> tangential = trial - pressing * normal;
    const double length = tangential.norm(), bound = friction * pressing;
    force = pressing * normal;
    if (length <= bound) {
      force += tangential;
    } else {
      held = bound / length;
      slip = tangential / length;
      force += bound * slip;
    }
  }

  /// -d force / d displacement.
  Matrix<Dim> stiffness(const Vector<Dim>& normal, double friction, double rho) const {
    return definite(normal, rho) + rho * friction * slip * normal.transpose();
  }
  /// Its symmetric part without the change of the friction bound: positive semi-definite.
  Matrix<Dim> definite(const Vector<Dim>& normal, double rho) const {
    const Matrix<Dim> nn = normal * normal.transpose();
    return rho * nn + rho * held * (Matrix<Dim>::Identity() - nn - slip * slip.transpose());
  }
};

}  // namespace jampack
