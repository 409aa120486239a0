// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <jampack/core/error.hpp>
#include <jampack/mesh/mesh.hpp>
#include <map>
#include <set>

namespace jampack {

/// Finds the faces that belong to one cell only (one macro, where there are macros: their faces are
/// quadratic) and the nodes on them; fills `mesh.faces` in the order of the cells, and `mesh.boundary_nodes`.
/// Throws InvalidInput if a face belongs to more than two cells.
template <int Dim>
void find_boundary(Mesh<Dim>& mesh) {
  // Face f of a simplex leaves out corner f. Its nodes, outward; mid nodes in the order of BoundaryFace.
  constexpr auto local_faces = [] {
    if constexpr (Dim == 2)
      return std::array<std::array<std::size_t, 3>, 3>{{{1, 2, 4}, {2, 0, 5}, {0, 1, 3}}};
    else
      return std::array<std::array<std::size_t, 6>, 4>{
          {{1, 2, 3, 5, 9, 8}, {0, 3, 2, 7, 9, 6}, {0, 1, 3, 4, 8, 7}, {0, 2, 1, 6, 5, 4}}};
  }();
  using Key = std::array<Index, Dim>;
  const auto key = [](const auto& simplex, const auto& local) {
    Key corners;
    for (std::size_t i = 0; i < Dim; ++i) corners[i] = simplex[local[i]];
    std::sort(corners.begin(), corners.end());
    return corners;
  };
  const auto collect = [&](const auto& simplices, std::size_t n_nodes) {
    std::map<Key, int> uses;
    for (const auto& simplex : simplices)
      for (const auto& local : local_faces) ++uses[key(simplex, local)];
    mesh.faces.clear();
    std::set<Index> boundary;
    for (const auto& simplex : simplices)
      for (const auto& local : local_faces) {
        const int n = uses[key(simplex, local)];
        require(n <= 2, "mesh: a face belongs to more than two cells");
        if (n == 2) continue;
        BoundaryFace<Dim> face{{}, static_cast<Index>(n_nodes)};
        face.node.fill(-1);
        for (std::size_t i = 0; i < n_nodes; ++i) {
          face.node[i] = simplex[local[i]];
          boundary.insert(face.node[i]);
        }
        mesh.faces.push_back(face);
      }
    mesh.boundary_nodes = Array<Index>(boundary.begin(), boundary.end());
  };
  if (mesh.macros.empty())
    collect(mesh.cells, Dim);
  else
    collect(mesh.macros, BoundaryFace<Dim>::n_quadratic_nodes);
}

}  // namespace jampack
