// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <jampack/core/error.hpp>
#include <jampack/element/averaged_dilatation.hpp>
#include <jampack/element/shape_gradients.hpp>
#include <jampack/mesh/mesh.hpp>
#include <string_view>

namespace jampack {

/// Locking-free linear element: the 4 | 8 linear cells of a macro share one averaged dilatation. The pair
/// "linear displacement on the refined, constant pressure on the coarse mesh" (P1 iso P2 / P0).
template <int Dim>
struct MacroSimplex : AveragedDilatation<Dim, Mesh<Dim>::n_macro_nodes, Mesh<Dim>::n_cells_a_macro, Dim + 1> {
  using Base = AveragedDilatation<Dim, Mesh<Dim>::n_macro_nodes, Mesh<Dim>::n_cells_a_macro, Dim + 1>;
  using typename Base::Cell;

  static constexpr std::string_view name = "macro";
  static constexpr bool linear_on_parts = true;

  /// One cell for each macro of the mesh; throws InvalidInput if the mesh has none.
  static Array<Cell> cells(const Mesh<Dim>& mesh, double diameter, const Matrix<Dim>& rotation) {
    require(!mesh.macros.empty(), "element macro: the mesh has no quadratic simplices");
    Array<Cell> cells;
    cells.reserve(mesh.macros.size());
    for (Index m = 0; m < mesh.macros.size(); ++m) {
      Cell& cell = cells.emplace_back();
      cell.node = mesh.macros[m];
      for (Index c = 0; c < Mesh<Dim>::n_cells_a_macro; ++c) {
        auto& point = cell.points[static_cast<std::size_t>(c)];
        for (std::size_t a = 0; a <= Dim; ++a) {
          const Index node = mesh.cells[m * Mesh<Dim>::n_cells_a_macro + c][a];
          const auto found = std::find(cell.node.begin(), cell.node.end(), node);
          require(found != cell.node.end(), "element macro: a cell has a node that its macro has not");
          point.support[a] = static_cast<int>(found - cell.node.begin());
        }
        std::sort(point.support.begin(), point.support.end());
        std::array<Index, Dim + 1> nodes;
        for (std::size_t a = 0; a <= Dim; ++a)
          nodes[a] = cell.node[static_cast<std::size_t>(point.support[a])];
        // Sorting may have turned the cell inside out, which changes the sign of its volume alone.
        point.volume = std::abs(
            linear_gradients<Dim>(reference_positions(mesh, nodes, diameter, rotation), point.gradients));
      }
      Base::finish(cell);
    }
    return cells;
  }

  /// Adds each node's share of the reference volume: that of the linear cells, in equal shares.
  static void add_volume_shares(const Cell& cell, typename Base::VolumeShares& shares) {
    for (const auto& point : cell.points)
      for (const int a : point.support) shares[a] += point.volume / (Dim + 1);
  }
};

}  // namespace jampack
