// SPDX-License-Identifier: MIT
#pragma once

#include <concepts>
#include <jampack/core/dimension.hpp>

namespace jampack {

/// Energy of a change of volume per reference volume, and its first two derivatives by the dilatation J.
struct VolumetricResponse {
  double energy, slope, curvature;
};

/// What a distortional energy needs to know of the deformation at a point.
template <int Dim>
struct Deformation {
  Matrix<Dim> gradient;           ///< F = dx/dX
  Matrix<Dim> inverse_transpose;  ///< F^-T, where the material is of finite strain
  double dilatation;              ///< J = det F at finite strain, 1 + tr(F - I) at small strain
};

/// A hyperelastic energy per reference volume, psi(F) = distortional(F) + volumetric(J): elements average J
/// over a patch of cells and keep F (docs/theory/elements.md, eq. 1). In 2D: plane strain.
///
/// `finite_strain` says which J is meant; `density` is the reference mass density; `validate()` throws
/// InvalidInput with one line if a parameter is out of its range. distortional_stress is the first
/// Piola-Kirchhoff stress, the derivative of the distortional energy by F.
template <class M, int Dim>
concept EnergyOfDeformation = requires(const M& material, const Deformation<Dim>& deformation) {
  { material.distortional_energy(deformation) } -> std::convertible_to<double>;
  { material.distortional_stress(deformation) } -> std::convertible_to<Matrix<Dim>>;
};

/// The distortional tangent in closed form: with reference gradients G and "spatial" gradients g = F^-T G (G
/// at small strain) of shape functions a and b,
///   dP:(.) contracted = isotropic (G_a . G_b) I + exchange g_b g_a^T.
struct GradientTangent {
  double isotropic, exchange;
};

template <class M, int Dim>
concept HasGradientTangent = requires(const M& material, const Deformation<Dim>& deformation) {
  { material.distortional_tangent(deformation) } -> std::same_as<GradientTangent>;
};

/// The distortional tangent as a matrix: entry (Dim j + i, Dim l + k) is dP_ij / dF_kl, symmetric.
template <int Dim>
using MatrixTangent = Eigen::Matrix<double, Dim * Dim, Dim * Dim>;

template <class M, int Dim>
concept HasMatrixTangent = requires(const M& material, const Deformation<Dim>& deformation) {
  { material.distortional_tangent(deformation) } -> std::same_as<MatrixTangent<Dim>>;
};

template <class M, int Dim>
concept Material = EnergyOfDeformation<M, Dim> &&
    (HasGradientTangent<M, Dim> || HasMatrixTangent<M, Dim>)&&requires(const M& material, double dilatation) {
  { M::finite_strain } -> std::convertible_to<bool>;
  { material.volumetric(dilatation) } -> std::same_as<VolumetricResponse>;
  { material.density } -> std::convertible_to<double>;
  material.validate();
};

/// Says its shear modulus at small strain, which elements that resist departures from a mean dilatation ask
/// for.
template <class M>
concept HasShearModulus = requires(const M& material) {
  { material.shear() } -> std::convertible_to<double>;
};

}  // namespace jampack
