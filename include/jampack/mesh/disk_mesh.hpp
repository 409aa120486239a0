// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <jampack/mesh/boundary.hpp>
#include <jampack/mesh/mesh.hpp>
#include <jampack/mesh/quality.hpp>
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
  // Mid nodes average radius and direction, so that they lie on circles.
  const auto middle = [&](Index a, Index b) {
    return add((radius[a] + radius[b]) / 2, (direction[a] + direction[b]).normalized());
  };
  for (Index k = 0; k <= shape.n_refinements; ++k) {
    mesh.macros = add_mid_nodes<2>(mesh.cells, middle);
    mesh.cells = refine_macros<2>(mesh.nodes, mesh.macros);
  }
  find_boundary(mesh);
  return mesh;
}

/// The best-shaped mesh within 4 % of the wanted number of linear cells, from 64 cells on; two to three times
/// as many macros on the circle as on the rim of the fan, 16 to 64 macros before refinement.
inline DiskMeshShape disk_mesh_shape(Index wanted_cells) {
  require(wanted_cells >= 64, "disk_mesh: at least 64 cells are needed");
  Index n_refinements = 0;
  double n_macros = static_cast<double>(wanted_cells) / 4;
  while (n_macros > 64) {
    n_macros /= 4;
    ++n_refinements;
  }
  DiskMeshShape best{};
  double best_ratio = 0;
  const Index nearest = std::lround(n_macros);
  const Index from = std::min(nearest, static_cast<Index>(std::ceil(0.96 * n_macros)));
  const Index to = std::max(nearest, static_cast<Index>(std::floor(1.04 * n_macros)));
  for (Index n = from; n <= to; ++n)
    for (Index n_inner = (n + 4) / 5; n_inner <= n / 4; ++n_inner)
      for (int i = 0; i < 10; ++i) {
        const DiskMeshShape shape{n_inner, n - 2 * n_inner, 0, 0.3 + 0.05 * i};
        const MeshQuality quality = mesh_quality(disk_mesh(shape));
        if (quality.min_scaled_jacobian < 0.2 || quality.min_radius_ratio <= best_ratio) continue;
        best_ratio = quality.min_radius_ratio;
        best = shape;
      }
  best.n_refinements = n_refinements;
  return best;
}

/// Disk of unit diameter with about the wanted number of linear cells.
inline Mesh<2> disk_mesh(Index wanted_cells) {
  return disk_mesh(disk_mesh_shape(wanted_cells));
}

}  // namespace jampack
