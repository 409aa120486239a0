// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/LU>
#include <array>
#include <jampack/core/array.hpp>
#include <jampack/core/dimension.hpp>

namespace jampack {

/// A face (an edge in 2D) of the boundary: corners first, outward by the right-hand rule (in 2D the interior
/// lies to the left of 0 -> 1), then, if the face is quadratic, the mid nodes in the order 01, 12, 20.
template <int Dim>
struct BoundaryFace {
  static constexpr int n_quadratic_nodes = Dim == 2 ? 3 : 6;
  std::array<Index, n_quadratic_nodes> node;
  Index n_nodes;  ///< Dim for a linear face, n_quadratic_nodes for a quadratic one
};

/// A simplex mesh. Where it comes from quadratic simplices ("macros") the linear cells are their refinement
/// over the same nodes, so that linear, macro and quadratic elements are compared at equal nodes.
///
/// Macro nodes: corners 0..Dim, then the mid nodes of the edges 01, 12, 20 and in 3D 03, 13, 23.
template <int Dim>
struct Mesh {
  static constexpr int n_macro_nodes = Dim == 2 ? 6 : 10;
  static constexpr int n_cells_a_macro = Dim == 2 ? 4 : 8;
  static constexpr int n_brick_nodes = Dim == 2 ? 4 : 8;

  Array<Vector<Dim>> nodes;
  Array<std::array<Index, Dim + 1>> cells;  ///< linear simplices of positive volume
  Array<std::array<Index, n_macro_nodes>>
      macros;                      ///< may be empty; macro m = cells [m k, (m + 1) k), k = 4 | 8
  Array<BoundaryFace<Dim>> faces;  ///< the whole boundary
  Array<Index> boundary_nodes;     ///< ascending
  /// Quadrilaterals or hexahedra over the same nodes, empty for most meshes (mesh/brick_mesh.hpp): bit d of a
  /// local node's number is its place along local axis d.
  Array<std::array<Index, n_brick_nodes>> bricks;
};

/// The corners of the edge on which macro mid node Dim + 1 + e lies.
template <int Dim>
inline constexpr auto macro_edges = [] {
  if constexpr (Dim == 2)
    return std::array<std::array<int, 2>, 3>{{{0, 1}, {1, 2}, {2, 0}}};
  else
    return std::array<std::array<int, 2>, 6>{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};
}();

/// Six times (in 2D twice) the signed volume of a simplex with the given corners.
template <int Dim, class Nodes>
double simplex_determinant(const Nodes& nodes, const std::array<Index, Dim + 1>& cell) {
  Matrix<Dim> edges;
  for (int i = 0; i < Dim; ++i) edges.col(i) = nodes[cell[static_cast<std::size_t>(i + 1)]] - nodes[cell[0]];
  return edges.determinant();
}

/// Volume (area in 2D) of the linear cells.
template <int Dim>
double mesh_volume(const Mesh<Dim>& mesh) {
  double volume = 0;
  for (const auto& cell : mesh.cells)
    volume += simplex_determinant<Dim>(mesh.nodes, cell) / (Dim == 2 ? 2 : 6);
  return volume;
}

}  // namespace jampack
