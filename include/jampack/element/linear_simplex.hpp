// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/element/averaged_dilatation.hpp>
#include <jampack/element/shape_gradients.hpp>
#include <jampack/mesh/mesh.hpp>
#include <string_view>

namespace jampack {

/// Linear triangle or tetrahedron: the baseline of the literature. It locks as nu -> 1/2.
template <int Dim>
struct LinearSimplex : AveragedDilatation<Dim, Dim + 1, 1, Dim + 1> {
  using Base = AveragedDilatation<Dim, Dim + 1, 1, Dim + 1>;
  using typename Base::Cell;

  static constexpr std::string_view name = "linear";
  static constexpr bool linear_on_parts = true;

  /// One cell for each linear cell of the mesh; reference positions are rotation * diameter * node.
  static Array<Cell> cells(const Mesh<Dim>& mesh, double diameter, const Matrix<Dim>& rotation) {
    Array<Cell> cells;
    cells.reserve(mesh.cells.size());
    for (Index c = 0; c < mesh.cells.size(); ++c) {
      Cell& cell = cells.emplace_back();
      cell.node = mesh.cells[c];
      for (int a = 0; a <= Dim; ++a) cell.points[0].support[static_cast<std::size_t>(a)] = a;
      const auto corners = reference_positions(mesh, cell.node, diameter, rotation);
      cell.points[0].volume = linear_gradients<Dim>(corners, cell.points[0].gradients);
      Base::finish(cell);
    }
    return cells;
  }

  /// Adds each node's share of the reference volume: equal shares.
  static void add_volume_shares(const Cell& cell, typename Base::VolumeShares& shares) {
    shares.array() += cell.volume / (Dim + 1);
  }
};

}  // namespace jampack
