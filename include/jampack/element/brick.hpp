// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <jampack/core/error.hpp>
#include <jampack/element/averaged_dilatation.hpp>
#include <jampack/element/shape_gradients.hpp>
#include <jampack/mesh/mesh.hpp>
#include <string_view>

namespace jampack {

/// Bilinear quadrilateral or trilinear hexahedron with one averaged dilatation (mean dilatation, Q1 / P0; J.
/// C. Nagtegaal, D. M. Parks and J. R. Rice 1974): the symmetric relative of F-bar. 2 x 2 (x 2) Gauss points,
/// which integrate the volume and the gradients of the shape functions exactly.
template <int Dim>
struct Brick
    : AveragedDilatation<Dim, Mesh<Dim>::n_brick_nodes, Mesh<Dim>::n_brick_nodes, Mesh<Dim>::n_brick_nodes> {
  static constexpr int n = Mesh<Dim>::n_brick_nodes;
  using Base = AveragedDilatation<Dim, n, n, n>;
  using typename Base::Cell;

  static constexpr std::string_view name = "brick";

  /// One cell for each brick of the mesh; throws InvalidInput if the mesh has none.
  static Array<Cell> cells(const Mesh<Dim>& mesh, double diameter, const Matrix<Dim>& rotation) {
    require(!mesh.bricks.empty(), "element brick: the mesh has no quadrilaterals or hexahedra");
    Array<Cell> cells;
    cells.reserve(mesh.bricks.size());
    for (const auto& brick : mesh.bricks) {
      Cell& cell = cells.emplace_back();
      cell.node = brick;
      const auto positions = reference_positions(mesh, brick, diameter, rotation);
      for (int q = 0; q < n; ++q) {
        auto& point = cell.points[static_cast<std::size_t>(q)];
        Eigen::Matrix<double, Dim, n> by_xi;  // derivatives of the shape functions on [0, 1]^Dim
        for (int a = 0; a < n; ++a) {
          point.support[static_cast<std::size_t>(a)] = a;
          for (int d = 0; d < Dim; ++d) {
            double derivative = bit(a, d) ? 1 : -1;
            for (int other = 0; other < Dim; ++other)
              if (other != d) derivative *= bit(a, other) == bit(q, other) ? near : far;
            by_xi(d, a) = derivative;
          }
        }
        const Matrix<Dim> jacobian = positions * by_xi.transpose();
        point.volume = jacobian.determinant() / n;
        point.gradients = jacobian.inverse().transpose() * by_xi;
      }
      Base::finish(cell);
    }
    return cells;
  }

  /// Adds each node's share of the reference volume: the integral of its shape function.
  static void add_volume_shares(const Cell& cell, typename Base::VolumeShares& shares) {
    for (int q = 0; q < n; ++q)
      for (int a = 0; a < n; ++a) {
        double shape = cell.points[static_cast<std::size_t>(q)].volume;
        for (int d = 0; d < Dim; ++d) shape *= bit(a, d) == bit(q, d) ? near : far;
        shares[a] += shape;
      }
  }

 private:
  // Gauss points on [0, 1]: one end has the share `near` of the point next to it.
  static constexpr double far = 0.21132486540518711775, near = 1 - far;
  static constexpr bool bit(int number, int place) { return (number >> place & 1) != 0; }
};

}  // namespace jampack
