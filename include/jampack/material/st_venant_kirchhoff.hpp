// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/material/isotropic_moduli.hpp>
#include <jampack/material/material.hpp>
#include <jampack/material/volume_energy.hpp>

namespace jampack {

/// St Venant-Kirchhoff solid with the volumetric energy of compression (J. Bonet and R. D. Wood, Nonlinear
/// Continuum Mechanics for Finite Element Analysis, 2008), psi = mu E:E + (lambda / 2) ln^2 J with Green's
/// strain E = (F^T F - I) / 2; plane strain in 2D. For comparison: at finite rotation and moderate strain.
///
/// Range: mu E:E softens in compression, d2psi/ds2 = mu (3 s^2 - 1) along a principal stretch s, and is not
/// elliptic below s = 0.58; the volumetric part, which elements average, does not make up for it.
struct StVenantKirchhoff {
  double young = 1;      ///< E > 0, stress
  double poisson = 0.3;  ///< in (-1, 0.5)
  double density = 1;    ///< reference density > 0

  static constexpr bool finite_strain = true;

  void validate() const { validate_isotropic(young, poisson, density); }
  double shear() const { return shear_modulus(young, poisson); }

  template <int Dim>
  double distortional_energy(const Deformation<Dim>& at) const {
    return shear() * strain(at).squaredNorm();
  }
  /// P = 2 mu F E
  template <int Dim>
  Matrix<Dim> distortional_stress(const Deformation<Dim>& at) const {
    return 2 * shear() * (at.gradient * strain(at));
  }
  /// dP = 2 mu (dF E + F sym(F^T dF))
  template <int Dim>
  MatrixTangent<Dim> distortional_tangent(const Deformation<Dim>& at) const {
    const double mu = shear();
    const Matrix<Dim> green = strain(at), left = at.gradient * at.gradient.transpose();
    MatrixTangent<Dim> tangent;
    for (int j = 0; j < Dim; ++j)
      for (int i = 0; i < Dim; ++i)
        for (int l = 0; l < Dim; ++l)
          for (int k = 0; k < Dim; ++k)
            tangent(Dim * j + i, Dim * l + k) =
                mu * ((i == k ? 2 * green(l, j) : 0) + (j == l ? left(i, k) : 0) +
                      at.gradient(i, l) * at.gradient(k, j));
    return tangent;
  }
  VolumetricResponse volumetric(double dilatation) const {
    return LogarithmicVolume::response(lame_modulus(young, poisson), dilatation);
  }

 private:
  template <int Dim>
  static Matrix<Dim> strain(const Deformation<Dim>& at) {
    return 0.5 * (at.gradient.transpose() * at.gradient - Matrix<Dim>::Identity());
  }
};

static_assert(Material<StVenantKirchhoff, 2> && Material<StVenantKirchhoff, 3>);

}  // namespace jampack
