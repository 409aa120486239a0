// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/body/cholesky_structure.hpp>
#include <jampack/element/element.hpp>
#include <jampack/mesh/boundary_surface.hpp>
#include <memory>

namespace jampack {

/// What all deformable grains cut from one reference mesh share: mesh and boundary (unit diameter),
/// material, sparsity and the order of elimination.
template <int Dim, class ElementType, class MaterialType>
struct GrainModel {
  using Element = ElementType;
  using Material = MaterialType;
  static constexpr int dimension = Dim;

  Mesh<Dim> mesh;
  Material material;
  Boundary<Dim> boundary;
  BlockPattern pattern;
  std::shared_ptr<const CholeskyStructure> cholesky;                             ///< of `pattern`
  Array<std::array<std::int32_t, Element::n_nodes * Element::n_nodes>> scatter;  ///< cell block -> pattern

  GrainModel(Mesh<Dim> reference, Material m) : mesh(std::move(reference)), material(m) {
    boundary = make_boundary(mesh);
    boundary.linear_on_parts = linear_on_parts<Element>;
    const auto cells = Element::cells(mesh, 1.0, Matrix<Dim>::Identity());
    Array<Array<Index>> groups;
    for (const auto& cell : cells) groups.emplace_back(cell.node.begin(), cell.node.end());
    // A contact on a face couples all its nodes, also where the cells do not.
    for (const auto& face : mesh.faces)
      groups.emplace_back(face.node.begin(), face.node.begin() + face.n_nodes);
    pattern = block_pattern(mesh.nodes.size(), groups);
    cholesky = std::make_shared<const CholeskyStructure>(pattern);
    for (const auto& cell : cells) {
      auto& map = scatter.emplace_back();
      for (std::size_t i = 0; i < Element::n_nodes; ++i)
        for (std::size_t j = 0; j < Element::n_nodes; ++j)
          map[i * Element::n_nodes + j] =
              static_cast<std::int32_t>(pattern.position(cell.node[i], cell.node[j]));
    }
  }
};

}  // namespace jampack
