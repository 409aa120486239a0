// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <jampack/mesh/boundary.hpp>
#include <jampack/mesh/mesh.hpp>
#include <jampack/mesh/refinement.hpp>
#include <numbers>

namespace jampack {

/// Shape of a disk mesh: a fan of `n_inner` macros about the centre, a ring of macros that joins its rim to
/// `n_outer` points on the circle, all refined in four `n_refinements` times.
struct DiskMeshShape {
  Index n_inner;        ///< >= 3
  Index n_outer;        ///< >= n_inner
  Index n_refinements;  ///< >= 0
  double inner_radius;  ///< of the fan, in (0, 1), the circle's being 1

  Index n_cells() const {
    Index n = 4 * (n_outer + 2 * n_inner);
    for (Index k = 0; k < n_refinements; ++k) n *= 4;
    return n;
  }
};

/// The shape whose number of linear cells is nearest to the wanted one, from 36 cells on.
inline DiskMeshShape disk_mesh_shape(Index wanted_cells) {
  require(wanted_cells >= 36, "disk_mesh: at least 36 cells are needed");
  Index n_refinements = 0;
  double n_macros = static_cast<double>(wanted_cells) / 4;
  while (n_macros > 64) {
    n_macros /= 4;
    ++n_refinements;
  }
  const Index n = std::lround(n_macros);
  const Index n_inner = std::max<Index>(3, std::lround(static_cast<double>(n) / 4.5));
  return {n_inner, n - 2 * n_inner, n_refinements, 0.5};
}

/// Disk of unit diameter, centred at 0, cells finer towards the circle. All boundary nodes, corners and mid
/// nodes, lie on the circle: the mesh is inscribed.
inline Mesh<2> disk_mesh(const DiskMeshShape& shape) {
  require(shape.n_inner >= 3 && shape.n_outer >= shape.n_inner,
          "disk_mesh: 3 <= n_inner <= n_outer is needed");
  Mesh<2> mesh;
  Array<double> radius;
  Array<Vector<2>> direction;
  const auto add = [&](double r, const Vector<2>& along) {
    radius.push_back(r);
    direction.push_back(along);
    mesh.nodes.push_back(0.5 * r * along);
    return radius.size() - 1;
  };
  const auto at_angle = [](double turns) {
    return Vector<2>(std::cos(2 * std::numbers::pi * turns), std::sin(2 * std::numbers::pi * turns));
  };
  const auto share = [](Index i, Index n) { return static_cast<double>(i) / static_cast<double>(n); };
  const Index centre = add(0, Vector<2>::Zero()), inner = 1, outer = 1 + shape.n_inner;
  for (Index i = 0; i < shape.n_inner; ++i) add(shape.inner_radius, at_angle(share(i, shape.n_inner)));
  for (Index i = 0; i < shape.n_outer; ++i) add(1, at_angle(share(i, shape.n_outer)));
  for (Index i = 0; i < shape.n_inner; ++i)
    mesh.cells.push_back({centre, inner + i, inner + (i + 1) % shape.n_inner});
  // Zip the two rims together: advance on the rim whose next edge ends first.
  for (Index i = 0, o = 0; i < shape.n_inner || o < shape.n_outer;) {
    const Index a = inner + i % shape.n_inner, b = outer + o % shape.n_outer;
    const bool outward = o < shape.n_outer && (i == shape.n_inner || share(2 * o + 1, shape.n_outer) <=
                                                                         share(2 * i + 1, shape.n_inner));
    if (outward)
      mesh.cells.push_back({a, b, outer + ++o % shape.n_outer});
    else
      mesh.cells.push_back({a, b, inner + ++i % shape.n_inner});
  }
  const auto middle = [&](Index a, Index b) {
    // Within the fan radii grow with the distance from the centre alone, elsewhere nodes lie on circles.
    return add((radius[a] + radius[b]) / 2, (direction[a] + direction[b]).normalized());
  };
  for (Index k = 0; k <= shape.n_refinements; ++k) {
    mesh.macros = add_mid_nodes<2>(mesh.cells, middle);
    mesh.cells = refine_macros<2>(mesh.nodes, mesh.macros);
  }
  find_boundary(mesh);
  return mesh;
}

/// Disk of unit diameter with about the wanted number of linear cells.
inline Mesh<2> disk_mesh(Index wanted_cells) {
  return disk_mesh(disk_mesh_shape(wanted_cells));
}

}  // namespace jampack
