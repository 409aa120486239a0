// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <jampack/material/isotropic_moduli.hpp>
#include <jampack/material/material.hpp>
#include <jampack/material/volume_energy.hpp>

namespace jampack {

/// Compressible neo-Hookean solid, psi = (mu / 2)(tr C - Dim - 2 ln J) + U(J) (docs/theory/elements.md, eq.
/// 2); plane strain in 2D. Valid at any strain with J > 0; mu and lambda are those of small strain.
template <class Volume>
struct BasicNeoHookean {
  double young = 1;      ///< E > 0, stress
  double poisson = 0.3;  ///< in (-1, 0.5)
  double density = 1;    ///< reference density > 0

  static constexpr bool finite_strain = true;

  void validate() const { validate_isotropic(young, poisson, density); }
  double shear() const { return shear_modulus(young, poisson); }

  template <int Dim>
  double distortional_energy(const Deformation<Dim>& at) const {
    const double mu = shear();
    return mu * (0.5 * (at.gradient.squaredNorm() - Dim) - std::log(at.dilatation));
  }
  /// P = mu (F - F^-T)
  template <int Dim>
  Matrix<Dim> distortional_stress(const Deformation<Dim>& at) const {
    return shear() * (at.gradient - at.inverse_transpose);
  }
  template <int Dim>
  GradientTangent distortional_tangent(const Deformation<Dim>&) const {
    const double mu = shear();
    return {mu, mu};
  }
  VolumetricResponse volumetric(double dilatation) const {
    return Volume::response(lame_modulus(young, poisson), dilatation);
  }
};

using NeoHookean = BasicNeoHookean<LogarithmicVolume>;
using NeoHookeanQuadratic = BasicNeoHookean<QuadraticVolume>;

static_assert(Material<NeoHookean, 2> && Material<NeoHookean, 3> && Material<NeoHookeanQuadratic, 3>);
static_assert(!Material<LogarithmicVolume, 3>);

}  // namespace jampack
