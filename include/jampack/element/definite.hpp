// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <jampack/material/material.hpp>

namespace jampack {

/// Largest eigenvalue of a symmetric matrix, in closed form.
template <int Dim>
double largest_eigenvalue(const Matrix<Dim>& a) {
  const double mean = a.trace() / Dim;
  if constexpr (Dim == 2) {
    return mean + std::hypot(0.5 * (a(0, 0) - a(1, 1)), a(0, 1));
  } else {
    const Matrix<Dim> deviator = a - mean * Matrix<Dim>::Identity();
    const double size = std::sqrt(deviator.squaredNorm() / 6);
    if (!(size > 0)) return mean;
    const double cosine = std::clamp(deviator.determinant() / (2 * size * size * size), -1.0, 1.0);
    return mean + 2 * size * std::cos(std::acos(cosine) / 3);
  }
}

/// Makes the closed-form tangent isotropic |L F|^2 + exchange tr(L L), L = dx/dx', positive semi-definite.
/// In principal stretches the pair (i, j) has the eigenvalues isotropic +- exchange / (s_i s_j); the lower,
/// that of rotation, is lifted by a term |skew L|^2 whose factor is changed in `tangent` and returned:
///   (G_a . G_b) isotropic + (g_a . g_b) rotational + g_b g_a^T exchange  (docs/theory/elements.md, eq. 8).
template <int Dim>
double make_definite(GradientTangent& tangent, const Deformation<Dim>& at) {
  double smallest_pair = at.dilatation;  // min s_i s_j = J / s_max in 3D, J in 2D
  if constexpr (Dim == 3)
    smallest_pair /= std::sqrt(largest_eigenvalue<Dim>(at.gradient.transpose() * at.gradient));
  const double excess = std::max(0.0, tangent.exchange - tangent.isotropic * smallest_pair);
  tangent.exchange -= excess / 2;
  return excess / 2;
}

/// Sets the negative eigenvalues of a tangent matrix to zero.
template <int Dim>
void make_definite(MatrixTangent<Dim>& tangent) {
  const Eigen::SelfAdjointEigenSolver<MatrixTangent<Dim>> spectrum(tangent);
  if (spectrum.eigenvalues()[0] >= 0) return;
  tangent = spectrum.eigenvectors() * spectrum.eigenvalues().cwiseMax(0).asDiagonal() *
            spectrum.eigenvectors().transpose();
}

}  // namespace jampack
