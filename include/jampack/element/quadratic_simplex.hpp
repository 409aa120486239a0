// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/core/error.hpp>
#include <jampack/element/averaged_dilatation.hpp>
#include <jampack/element/shape_gradients.hpp>
#include <jampack/mesh/mesh.hpp>
#include <string_view>

namespace jampack {

/// Quadratic triangle or tetrahedron with curved sides and one averaged dilatation (P2 / P0), 3 | 4 points.
template <int Dim>
struct QuadraticSimplex
    : AveragedDilatation<Dim, Mesh<Dim>::n_macro_nodes, Dim + 1, Mesh<Dim>::n_macro_nodes> {
  using Base = AveragedDilatation<Dim, Mesh<Dim>::n_macro_nodes, Dim + 1, Mesh<Dim>::n_macro_nodes>;
  using typename Base::Cell;

  static constexpr std::string_view name = "quadratic";

  /// One cell for each macro of the mesh; throws InvalidInput if the mesh has none.
  static Array<Cell> cells(const Mesh<Dim>& mesh, double diameter, const Matrix<Dim>& rotation) {
    require(!mesh.macros.empty(), "element quadratic: the mesh has no quadratic simplices");
    Array<Cell> cells;
    cells.reserve(mesh.macros.size());
    for (Index m = 0; m < mesh.macros.size(); ++m) {
      Cell& cell = cells.emplace_back();
      cell.node = mesh.macros[m];
      const auto positions = reference_positions(mesh, cell.node, diameter, rotation);
      for (std::size_t q = 0; q <= Dim; ++q) {
        auto& point = cell.points[q];
        for (int a = 0; a < Base::n_nodes; ++a) point.support[static_cast<std::size_t>(a)] = a;
        point.volume = quadratic_gradients<Dim>(positions, quadratic_points<Dim>()[q], point.gradients) *
                       reference_simplex_volume<Dim> / (Dim + 1);
      }
      Base::finish(cell);
    }
    return cells;
  }

  /// Adds each node's share of the reference volume: the diagonal of the consistent mass, scaled to the
  /// cell's volume (Hinton, Rock and Zienkiewicz 1976), because row sums are negative at the corners.
  static void add_volume_shares(const Cell& cell, typename Base::VolumeShares& shares) {
    typename Base::VolumeShares diagonal = Base::VolumeShares::Zero();
    for (std::size_t q = 0; q <= Dim; ++q)
      diagonal +=
          cell.points[q].volume * quadratic_shapes<Dim>(quadratic_points<Dim>()[q]).cwiseAbs2().transpose();
    shares += diagonal * (cell.volume / diagonal.sum());
  }
};

}  // namespace jampack
