// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <jampack/mesh/boundary.hpp>
#include <jampack/mesh/mesh.hpp>
#include <jampack/mesh/refinement.hpp>
#include <jampack/mesh/sphere_points.hpp>
#include <limits>

namespace jampack {

/// Shape of a ball mesh: `n_points` points on the sphere are triangulated, every triangle is the base of a
/// macro with its tip in the centre, and the macros are refined in eight `n_refinements` times.
struct BallMeshShape {
  Index n_points;       ///< >= 4
  Index n_refinements;  ///< >= 0
  double grading;       ///< in [0, 1): the share rho of the flat radius lies at R rho (1 + grading (1 - rho))

  Index n_cells() const {
    Index n = 8 * (2 * n_points - 4);
    for (Index k = 0; k < n_refinements; ++k) n *= 8;
    return n;
  }
};

/// The shape whose number of linear cells is nearest to the wanted one, from 32 cells on: at most 304 tips
/// meet in the centre, so cells coarsen inwards and stay well shaped.
inline BallMeshShape ball_mesh_shape(Index wanted_cells) {
  require(wanted_cells >= 32, "ball_mesh: at least 32 cells are needed");
  Index n_refinements = 0;
  double n_triangles = static_cast<double>(wanted_cells) / 8;
  while (n_triangles > 304) {
    n_triangles /= 8;
    ++n_refinements;
  }
  const Index n_points = std::max<Index>(4, static_cast<Index>(std::lround(n_triangles / 2)) + 2);
  return {n_points, n_refinements, n_refinements == 0 ? 0.4 : 0.5};
}

/// Ball of unit diameter, centred at 0, cells finer towards the surface. All boundary nodes, corners and mid
/// nodes, lie on the sphere: the mesh is inscribed.
inline Mesh<3> ball_mesh(const BallMeshShape& shape) {
  Mesh<3> mesh;
  // Flat radius rho in [0, 1] and direction of each node: mid nodes average both, so that they lie on shells.
  Array<double> rho;
  Array<Vector<3>> direction;
  const auto add = [&](double flat_radius, const Vector<3>& along) {
    rho.push_back(flat_radius);
    direction.push_back(along);
    mesh.nodes.push_back(0.5 * flat_radius * (1 + shape.grading * (1 - flat_radius)) * along);
    return rho.size() - 1;
  };
  const auto points = sphere_points(shape.n_points);
  for (const auto& point : points) add(1, point);
  const Index centre = add(0, Vector<3>::Zero());
  for (const auto& t : sphere_triangulation(points)) mesh.cells.push_back({centre, t[0], t[1], t[2]});
  const auto middle = [&](Index a, Index b) {
    return add((rho[a] + rho[b]) / 2, (direction[a] + direction[b]).normalized());
  };
  for (Index k = 0; k <= shape.n_refinements; ++k) {
    mesh.macros = add_mid_nodes<3>(mesh.cells, middle);
    mesh.cells = refine_macros<3>(mesh.nodes, mesh.macros);
  }
  find_boundary(mesh);
  return mesh;
}

/// Ball of unit diameter with about the wanted number of linear cells.
inline Mesh<3> ball_mesh(Index wanted_cells) {
  return ball_mesh(ball_mesh_shape(wanted_cells));
}

}  // namespace jampack
