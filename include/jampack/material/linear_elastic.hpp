// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/material/isotropic_moduli.hpp>
#include <jampack/material/material.hpp>

namespace jampack {

/// Isotropic linear elasticity, psi = mu eps:eps + (lambda / 2) (tr eps)^2, plane strain in 2D. For
/// verification: valid at small strain and small rotation only, because eps is not invariant under finite
/// rotation.
struct LinearElastic {
  double young = 1;      ///< E > 0, stress
  double poisson = 0.3;  ///< in (-1, 0.5)
  double density = 1;    ///< density > 0

  static constexpr bool finite_strain = false;

  void validate() const { validate_isotropic(young, poisson, density); }
  double shear() const { return shear_modulus(young, poisson); }

  template <int Dim>
  double distortional_energy(const Deformation<Dim>& at) const {
    return shear() * strain(at).squaredNorm();
  }
  template <int Dim>
  Matrix<Dim> distortional_stress(const Deformation<Dim>& at) const {
    return 2 * shear() * strain(at);
  }
  template <int Dim>
  GradientTangent distortional_tangent(const Deformation<Dim>&) const {
    const double mu = shear();
    return {mu, mu};
  }
  /// In the dilatation 1 + tr eps.
  VolumetricResponse volumetric(double dilatation) const {
    const double lame = lame_modulus(young, poisson), change = dilatation - 1;
    return {0.5 * lame * change * change, lame * change, lame};
  }

 private:
  template <int Dim>
  static Matrix<Dim> strain(const Deformation<Dim>& at) {
    return 0.5 * (at.gradient + at.gradient.transpose()) - Matrix<Dim>::Identity();
  }
};

static_assert(Material<LinearElastic, 2> && Material<LinearElastic, 3>);

}  // namespace jampack
