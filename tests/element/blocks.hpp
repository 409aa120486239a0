// SPDX-License-Identifier: MIT
// Meshes of blocks for the tests of elements.
#pragma once

#include <algorithm>

#include "solid.hpp"

namespace jampack_tests {

/// Makes macros of a simplex mesh of straight edges, then moves each mid node by `place`.
template <int Dim, class Place>
void add_macros(Mesh<Dim>& mesh, Place place) {
  mesh.macros = add_mid_nodes<Dim>(mesh.cells, [&](Index a, Index b) {
    mesh.nodes.push_back(place(mesh.nodes[a], mesh.nodes[b]));
    return mesh.nodes.size() - 1;
  });
  mesh.cells = refine_macros<Dim>(mesh.nodes, mesh.macros);
  find_boundary(mesh);
}

template <int Dim>
Vector<Dim> straight(const Vector<Dim>& a, const Vector<Dim>& b) {
  return (a + b) / 2;
}

/// n_x x n_y quadrilaterals cut in two, the unit square mapped by `place`; without macros and boundary.
template <class Place>
Mesh<2> triangles(Index n_x, Index n_y, Place place) {
  Mesh<2> mesh;
  for (Index j = 0; j <= n_y; ++j)
    for (Index i = 0; i <= n_x; ++i)
      mesh.nodes.push_back(place(static_cast<double>(i) / static_cast<double>(n_x),
                                 static_cast<double>(j) / static_cast<double>(n_y)));
  for (Index j = 0; j < n_y; ++j)
    for (Index i = 0; i < n_x; ++i) {
      const Index low = i + j * (n_x + 1), high = low + n_x + 1;
      mesh.cells.push_back({low, low + 1, high + 1});
      mesh.cells.push_back({low, high + 1, high});
    }
  return mesh;
}

/// The mesh in which n_x x n_y quadrilaterals of two macros serve an element: for bricks, twice as many
/// quadrilaterals a side, so that all elements have the same nodes.
template <class Element, class Place>
Mesh<2> block_mesh(Index n_x, Index n_y, Place place) {
  if (Element::name != "brick") {
    Mesh<2> mesh = triangles(n_x, n_y, place);
    add_macros(mesh, straight<2>);
    return mesh;
  }
  Mesh<2> mesh = triangles(2 * n_x, 2 * n_y, place);
  for (Index j = 0; j < 2 * n_y; ++j)
    for (Index i = 0; i < 2 * n_x; ++i) {
      const Index low = i + j * (2 * n_x + 1), high = low + 2 * n_x + 1;
      mesh.bricks.push_back({low, low + 1, high, high + 1});
    }
  find_boundary(mesh);
  return mesh;
}

/// Stacks `n_layers` layers of prisms over a triangle mesh, each cut in three tetrahedra (along the diagonals
/// that start at the node of the smaller number, so that neighbours agree).
inline Mesh<3> extruded(const Mesh<2>& base, double height, Index n_layers) {
  Mesh<3> mesh;
  const Index n = base.nodes.size();
  for (Index l = 0; l <= n_layers; ++l)
    for (const auto& node : base.nodes)
      mesh.nodes.push_back(
          {node[0], node[1], height * static_cast<double>(l) / static_cast<double>(n_layers)});
  for (Index l = 0; l < n_layers; ++l)
    for (auto t : base.cells) {
      std::sort(t.begin(), t.end());
      const Index low = l * n, high = low + n;
      for (std::array<Index, 4> cell : {std::array{low + t[0], low + t[1], low + t[2], high + t[2]},
                                        std::array{low + t[0], low + t[1], high + t[1], high + t[2]},
                                        std::array{low + t[0], high + t[0], high + t[1], high + t[2]}}) {
        if (simplex_determinant<3>(mesh.nodes, cell) < 0) std::swap(cell[0], cell[1]);
        mesh.cells.push_back(cell);
      }
    }
  return mesh;
}

}  // namespace jampack_tests
