// SPDX-License-Identifier: MIT
// A material of one's own: all that jampack asks of it is in <jampack/material/material.hpp>.
#pragma once

#include <cmath>
#include <jampack/material/material.hpp>

/// Rubber that stiffens exponentially (after Y. C. Fung):
///   psi = mu / (2 b) (exp(b (tr C - Dim)) - 1) - mu ln J + (lambda / 2) (J - 1)^2,  b > 0.
struct StiffeningSolid {
  double mu = 1, lambda = 10, b = 2, density = 1;

  static constexpr bool finite_strain = true;

  void validate() const {
    jampack::require(mu > 0 && lambda >= 0 && b > 0 && density > 0,
                     "stiffening solid: a parameter is out of range");
  }

  template <int Dim>
  double distortional_energy(const jampack::Deformation<Dim>& at) const {
    return mu * (0.5 * (growth(at) - 1) / b - std::log(at.dilatation));
  }
  template <int Dim>
  jampack::Matrix<Dim> distortional_stress(const jampack::Deformation<Dim>& at) const {
    return mu * (growth(at) * at.gradient - at.inverse_transpose);
  }
  template <int Dim>
  jampack::MatrixTangent<Dim> distortional_tangent(const jampack::Deformation<Dim>& at) const {
    const Eigen::Matrix<double, Dim * Dim, 1> gradient = at.gradient.reshaped();
    jampack::MatrixTangent<Dim> tangent = 2 * b * mu * growth(at) * gradient * gradient.transpose();
    tangent.diagonal().array() += mu * growth(at);
    for (int i = 0; i < Dim; ++i)
      for (int j = 0; j < Dim; ++j)
        for (int k = 0; k < Dim; ++k)
          for (int l = 0; l < Dim; ++l)
            tangent(Dim * j + i, Dim * l + k) += mu * at.inverse_transpose(i, l) * at.inverse_transpose(k, j);
    return tangent;
  }
  jampack::VolumetricResponse volumetric(double J) const {
    return {0.5 * lambda * (J - 1) * (J - 1), lambda * (J - 1), lambda};
  }

 private:
  template <int Dim>
  double growth(const jampack::Deformation<Dim>& at) const {
    return std::exp(b * (at.gradient.squaredNorm() - Dim));
  }
};

static_assert(jampack::Material<StiffeningSolid, 2> && jampack::Material<StiffeningSolid, 3>);
