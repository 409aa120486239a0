// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Eigenvalues>
#include <cmath>
#include <jampack/material/isotropic_moduli.hpp>
#include <jampack/material/material.hpp>
#include <jampack/material/volume_energy.hpp>

namespace jampack {

/// Hencky's solid, Hooke's law in the logarithmic strain: psi = mu sum_i ln^2 s_i + (lambda / 2) ln^2 J with
/// principal stretches s_i; plane strain in 2D. Tension and compression are alike: psi(F) = psi(F^-1).
///
/// Range: elliptic for stretches in [0.2116, 1.3956] (O. T. Bruhns, H. Xiao and A. Meyers, Proc. R. Soc. A
/// 457, 2001). An eigenvalue problem at each point: some five times the cost of NeoHookean.
struct Hencky {
  double young = 1;      ///< E > 0, stress
  double poisson = 0.3;  ///< in (-1, 0.5)
  double density = 1;    ///< reference density > 0

  static constexpr bool finite_strain = true;

  void validate() const { validate_isotropic(young, poisson, density); }
  double shear() const { return shear_modulus(young, poisson); }

  template <int Dim>
  double distortional_energy(const Deformation<Dim>& at) const {
    const Principal<Dim> principal(at.gradient);
    return shear() * principal.log_stretch.squaredNorm();
  }
  /// P = sum_i (2 mu ln s_i / s_i) u_i v_i^T
  template <int Dim>
  Matrix<Dim> distortional_stress(const Deformation<Dim>& at) const {
    const Principal<Dim> principal(at.gradient);
    return principal.left * slopes(principal).asDiagonal() * principal.right.transpose();
  }
  /// In principal axes: dP_ii = psi_ii dF_ii and, for i != j, dP_ij = A dF_ij + B dF_ji with
  ///   A + B = (psi_i - psi_j) / (s_i - s_j),  A - B = (psi_i + psi_j) / (s_i + s_j).
  template <int Dim>
  MatrixTangent<Dim> distortional_tangent(const Deformation<Dim>& at) const {
    const Principal<Dim> principal(at.gradient);
    const Vector<Dim> slope = slopes(principal);
    const auto& s = principal.stretch;
    const auto dyad = [&](int i, int j) {
      const Matrix<Dim> product = principal.left.col(i) * principal.right.col(j).transpose();
      return Eigen::Matrix<double, Dim * Dim, 1>(product.reshaped());
    };
    MatrixTangent<Dim> tangent = MatrixTangent<Dim>::Zero();
    for (int i = 0; i < Dim; ++i) {
      tangent += curvature(s[i]) * dyad(i, i) * dyad(i, i).transpose();
      for (int j = 0; j < i; ++j) {
        const double apart = s[i] - s[j], both = s[i] + s[j];
        const double even =
            std::abs(apart) > 1e-5 * both ? (slope[i] - slope[j]) / apart : curvature(both / 2);
        const double odd = (slope[i] + slope[j]) / both;
        const auto one = dyad(i, j), other = dyad(j, i);
        tangent += (even + odd) / 2 * (one * one.transpose() + other * other.transpose()) +
                   (even - odd) / 2 * (one * other.transpose() + other * one.transpose());
      }
    }
    return tangent;
  }
  VolumetricResponse volumetric(double dilatation) const {
    return LogarithmicVolume::response(lame_modulus(young, poisson), dilatation);
  }

 private:
  /// F = sum_i s_i u_i v_i^T
  template <int Dim>
  struct Principal {
    Vector<Dim> stretch, log_stretch;
    Matrix<Dim> left, right;

    explicit Principal(const Matrix<Dim>& gradient) {
      const Eigen::SelfAdjointEigenSolver<Matrix<Dim>> spectrum(gradient.transpose() * gradient);
      stretch = spectrum.eigenvalues().cwiseSqrt();
      log_stretch = stretch.array().log();
      right = spectrum.eigenvectors();
      left = gradient * right * stretch.cwiseInverse().asDiagonal();
    }
  };

  /// psi_i = d psi_d / ds_i
  template <int Dim>
  Vector<Dim> slopes(const Principal<Dim>& principal) const {
    return 2 * shear() * principal.log_stretch.cwiseQuotient(principal.stretch);
  }
  double curvature(double stretch) const {
    return 2 * shear() * (1 - std::log(stretch)) / (stretch * stretch);
  }
};

static_assert(Material<Hencky, 2> && Material<Hencky, 3>);

}  // namespace jampack
