// SPDX-License-Identifier: MIT
// A finite element of one's own, written from nothing: all that jampack asks of it is in
// <jampack/element/element.hpp>. (Elements with points that share a dilatation need only their points: see
// <jampack/element/brick.hpp>.)
#pragma once

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <jampack/element/element.hpp>
#include <jampack/material/material.hpp>
#include <limits>

/// Linear tetrahedron for materials with a tangent matrix.
struct PlainTetrahedron {
  static constexpr int n_nodes = 4;
  static constexpr std::string_view name = "plain";
  using Nodal = Eigen::Matrix<double, 3, 4>;
  using Tangent = Eigen::Matrix<double, 12, 12>;
  using VolumeShares = Eigen::Matrix<double, 1, 4>;

  struct Cell {
    std::array<jampack::Index, 4> node;
    double volume;
    Nodal gradients;
  };

  static jampack::Array<Cell> cells(const jampack::Mesh<3>& mesh, double diameter,
                                    const jampack::Matrix<3>& rotation) {
    jampack::Array<Cell> all;
    for (const auto& node : mesh.cells) {
      Nodal x;
      for (int a = 0; a < 4; ++a)
        x.col(a) = rotation * mesh.nodes[node[static_cast<std::size_t>(a)]] * diameter;
      const jampack::Matrix<3> edges = x.rightCols<3>().colwise() - x.col(0);
      jampack::require(edges.determinant() > 0, "plain tetrahedron: a cell has no volume");
      Cell& cell = all.emplace_back(Cell{node, edges.determinant() / 6, Nodal()});
      cell.gradients.rightCols<3>() = edges.inverse().transpose();
      cell.gradients.col(0) = -cell.gradients.rightCols<3>().rowwise().sum();
    }
    return all;
  }

  template <class M>
  static double energy(const Cell& cell, const M& material, const Nodal& x) {
    const auto at = deformation(cell, x);
    if (!(at.dilatation > 0)) return std::numeric_limits<double>::infinity();
    return cell.volume * (material.distortional_energy(at) + material.volumetric(at.dilatation).energy);
  }

  template <class M>
  static bool force(const Cell& cell, const M& material, const Nodal& x, Nodal& f) {
    const auto at = deformation(cell, x);
    if (!(at.dilatation > 0)) return false;
    f = cell.volume *
        (material.distortional_stress(at) +
         material.volumetric(at.dilatation).slope * at.dilatation * at.inverse_transpose) *
        cell.gradients;
    return true;
  }

  template <class M>
  requires jampack::HasMatrixTangent<M, 3>
  static bool force_and_tangent(const Cell& cell, const M& material, const Nodal& x, Nodal& f, Tangent& k) {
    if (!force(cell, material, x, f)) return false;
    const auto at = deformation(cell, x);
    const auto [energy, slope, curvature] = material.volumetric(at.dilatation);
    const jampack::Matrix<3> cofactor = at.dilatation * at.inverse_transpose;
    jampack::MatrixTangent<3> moduli = material.distortional_tangent(at);
    for (int i = 0; i < 9; ++i)
      for (int j = 0; j < 9; ++j)
        moduli(i, j) += curvature * cofactor(i) * cofactor(j) +
                        slope *
                            (cofactor(i) * cofactor(j) - cofactor(i % 3, j / 3) * cofactor(j % 3, i / 3)) /
                            at.dilatation;
    Eigen::Matrix<double, 9, 12> shape = Eigen::Matrix<double, 9, 12>::Zero();  // dF by dx
    for (int a = 0; a < 4; ++a)
      for (int i = 0; i < 9; ++i) shape(i, 3 * a + i % 3) = cell.gradients(i / 3, a);
    k = cell.volume * shape.transpose() * moduli * shape;
    return true;
  }

  /// Negative eigenvalues removed from the whole matrix.
  template <class M>
  requires jampack::HasMatrixTangent<M, 3>
  static bool force_and_definite_tangent(const Cell& cell, const M& material, const Nodal& x, Nodal& f,
                                         Tangent& k) {
    if (!force_and_tangent(cell, material, x, f, k)) return false;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum{Eigen::MatrixXd(k)};
    k = spectrum.eigenvectors() * spectrum.eigenvalues().cwiseMax(0).asDiagonal() *
        spectrum.eigenvectors().transpose();
    return true;
  }

  static double min_jacobian(const Cell& cell, const Nodal& x) { return deformation(cell, x).dilatation; }

  static void add_volume_shares(const Cell& cell, VolumeShares& shares) { shares.array() += cell.volume / 4; }

  template <class M, class Visit>
  static void for_each_point(const Cell& cell, const M& material, const Nodal& x, Visit visit) {
    const auto at = deformation(cell, x);
    jampack::Matrix<3> stress = material.distortional_stress(at) * at.gradient.transpose() / at.dilatation;
    stress.diagonal().array() += material.volumetric(at.dilatation).slope;
    visit(cell.volume, stress, at.dilatation);
  }

 private:
  static jampack::Deformation<3> deformation(const Cell& cell, const Nodal& x) {
    const jampack::Matrix<3> gradient = x * cell.gradients.transpose();
    return {gradient, gradient.inverse().transpose(), gradient.determinant()};
  }
};
