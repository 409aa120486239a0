// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <jampack/mesh/mesh.hpp>
#include <utility>

namespace jampack {

/// A linear simplex between neighbouring nodes of a face: a linear face is one, a quadratic one two of them
/// (in 2D) or four, oriented as the face is.
template <int Dim>
struct SurfacePart {
  Index face;
  std::array<Index, Dim> local;  ///< numbers of its corners among the nodes of the face
  std::array<Index, Dim> node;   ///< of the mesh
};

template <int Dim>
struct SurfaceParts {
  Array<SurfacePart<Dim>> part;
  /// Of the i-th boundary node: the parts that meet there, each with which of its corners the node is.
  Array<Array<std::pair<Index, std::size_t>>> of_node;
};

/// The parts of the whole boundary of a mesh.
template <int Dim>
SurfaceParts<Dim> surface_parts(const Array<BoundaryFace<Dim>>& faces, const Array<Index>& boundary_nodes,
                                Index n_mesh_nodes) {
  const Array<std::array<Index, Dim>> of_quadratic = [] {
    if constexpr (Dim == 2)
      return Array<std::array<Index, 2>>{{0, 2}, {2, 1}};
    else
      return Array<std::array<Index, 3>>{{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}};
  }();
  Array<std::array<Index, Dim>> of_linear(1);
  for (std::size_t i = 0; i < Dim; ++i) of_linear[0][i] = Index(i);
  Array<Index> number(n_mesh_nodes, -1);
  for (Index i = 0; i < boundary_nodes.size(); ++i) number[boundary_nodes[i]] = i;
  SurfaceParts<Dim> parts;
  parts.of_node.resize(boundary_nodes.size());
  for (Index f = 0; f < faces.size(); ++f)
    for (const auto& local : faces[f].n_nodes == Dim ? of_linear : of_quadratic) {
      SurfacePart<Dim> part{f, local, {}};
      for (std::size_t i = 0; i < Dim; ++i) {
        part.node[i] = faces[f].node[std::size_t(local[i])];
        parts.of_node[number[part.node[i]]].push_back({parts.part.size(), i});
      }
      parts.part.push_back(part);
    }
  return parts;
}

}  // namespace jampack
