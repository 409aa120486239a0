// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <jampack/core/error.hpp>
#include <jampack/mesh/boundary.hpp>
#include <jampack/mesh/mesh.hpp>
#include <jampack/mesh/refinement.hpp>
#include <map>
#include <numbers>

namespace jampack {

/// Shape of a mesh of bricks: a core of `n_core` blocks a side, wrapped in `n_layers` layers of blocks that
/// lead to the sphere (a "cubed sphere"; in 2D a square in a disk). A block is 2 x 2 (x 2) bricks.
struct BrickMeshShape {
  Index n_core;            ///< >= 1
  Index n_layers;          ///< >= 1
  double core_size = 0.4;  ///< half the side of the core, the sphere's radius being 1
  double roundness = 0.5;  ///< of the core, in [0, 1): 0 a cube
  double grading = 0.25;   ///< in [0, 1): the outermost layers are thinner by 1 - grading

  Index n_bricks(int dim) const {
    const Index n = 2 * n_core, m = 2 * n_layers;
    return dim == 2 ? n * n + 4 * n * m : n * n * n + 6 * n * n * m;
  }
};

namespace detail {

/// Cuts a brick in two triangles or five tetrahedra. Corners are of two colours, as on a chess board; the
/// diagonals join those of the colour of corner 0 or, if `odd`, of corner 1: in 3D each corner of the other
/// colour is cut off by its three neighbours.
template <int Dim, class Nodes>
void cut_brick(const Nodes& nodes, const std::array<Index, Mesh<Dim>::n_brick_nodes>& corner, bool odd,
               Array<std::array<Index, Dim + 1>>& simplices) {
  const auto add = [&](const std::array<unsigned, Dim + 1>& local) {
    std::array<Index, Dim + 1> simplex;
    for (std::size_t i = 0; i <= Dim; ++i) simplex[i] = corner[local[i]];
    if (simplex_determinant<Dim>(nodes, simplex) < 0) std::swap(simplex[0], simplex[1]);
    simplices.push_back(simplex);
  };
  for (unsigned cut_off = 0; cut_off < corner.size(); ++cut_off) {
    if ((std::popcount(cut_off) % 2 == 1) == odd) continue;
    std::array<unsigned, Dim + 1> local{cut_off};
    for (unsigned d = 0; d < Dim; ++d) local[d + 1] = cut_off ^ (1U << d);
    add(local);
  }
  const unsigned first = odd ? 1 : 0;
  if constexpr (Dim == 3) add({first, first ^ 3U, first ^ 5U, first ^ 6U});
}

}  // namespace detail

/// Ball of unit diameter (disk in 2D), centred at 0, made of quadrilaterals or hexahedra; inscribed. Its
/// linear cells are the bricks, each cut in two triangles or five tetrahedra; there are no macros. Faces are
/// quadratic, two for each face of a block, so that contact sees them as it sees those of any other mesh.
template <int Dim>
Mesh<Dim> brick_mesh(const BrickMeshShape& shape) {
  require(shape.n_core >= 1 && shape.n_layers >= 1, "brick_mesh: at least one block and one layer");
  const Index n = 2 * shape.n_core, m = 2 * shape.n_layers;
  Mesh<Dim> mesh;
  // A node's name: its place on the lattice of the core and its layer, 0 in the core, m on the sphere.
  using Name = std::array<Index, Dim + 1>;
  std::map<Name, Index> known;
  const auto node = [&](const Name& name) {
    const auto [entry, is_new] = known.try_emplace(name, mesh.nodes.size());
    if (!is_new) return entry->second;
    Vector<Dim> lattice, even;  // in the cube [-1, 1]^Dim; spaced by equal angles
    for (int d = 0; d < Dim; ++d) {
      lattice[d] = 2 * static_cast<double>(name[static_cast<std::size_t>(d)]) / static_cast<double>(n) - 1;
      even[d] = std::tan(std::numbers::pi / 4 * lattice[d]);
    }
    const double size = lattice.cwiseAbs().maxCoeff();
    Vector<Dim> core = shape.core_size * lattice;
    if (size > 0)
      core = shape.core_size * ((1 - shape.roundness) * lattice +
                                shape.roundness * std::sqrt(Dim / 2.0) * size * even.normalized());
    const double t = static_cast<double>(name[Dim]) / static_cast<double>(m);
    const double share = t * (1 + shape.grading * (1 - t));
    mesh.nodes.push_back(t == 0   ? Vector<Dim>(0.5 * core)
                         : t == 1 ? Vector<Dim>(0.5 * even.normalized())
                                  : Vector<Dim>(0.5 * ((1 - share) * core + share * even.normalized())));
    return entry->second;
  };
  // A block from its first lattice point and its local axes, each a step between names.
  Array<std::array<Index, Dim + 1>> block_simplices;
  const auto add_block = [&](const Name& origin, const std::array<Name, Dim>& axis) {
    constexpr auto n_corners = static_cast<unsigned>(Mesh<Dim>::n_brick_nodes);
    const auto corner = [&](Name from, unsigned bits, Index step) {
      for (std::size_t d = 0; d < Dim; ++d)
        for (std::size_t i = 0; i <= Dim; ++i) from[i] += (bits >> d & 1U ? step : 0) * axis[d][i];
      return from;
    };
    const auto corners = [&](const Name& from, Index step) {
      std::array<Index, n_corners> nodes{};
      for (unsigned a = 0; a < n_corners; ++a) nodes[a] = node(corner(from, a, step));
      return nodes;
    };
    const auto is_odd = [](const Name& name, Index step) {
      Index sum = 0;
      for (const Index i : name) sum += i / step;
      return sum % 2 != 0;
    };
    for (unsigned part = 0; part < n_corners; ++part) {
      const Name from = corner(origin, part, 1);
      auto brick = corners(from, 1);
      detail::cut_brick<Dim>(mesh.nodes, brick, is_odd(from, 1), mesh.cells);
      Matrix<Dim> edges;
      for (int d = 0; d < Dim; ++d) edges.col(d) = mesh.nodes[brick[1U << d]] - mesh.nodes[brick[0]];
      if (edges.determinant() < 0)
        for (std::size_t a = 0; a < n_corners; a += 2) std::swap(brick[a], brick[a + 1]);
      mesh.bricks.push_back(brick);
    }
    detail::cut_brick<Dim>(mesh.nodes, corners(origin, 2), is_odd(origin, 2), block_simplices);
  };
  const auto step = [](std::size_t along) {
    Name name{};
    name[along] = 1;
    return name;
  };
  // The core, then the layers on each of its sides.
  const auto for_each_place = [&](auto&& visit, Index skipped_axis = Dim) {
    std::array<Index, Dim> place{};
    for (std::size_t d = 0; d < Dim;) {
      visit(place);
      for (d = 0; d < Dim; ++d) {
        if (static_cast<Index>(d) == skipped_axis) continue;
        if ((place[d] += 2) < n) break;
        place[d] = 0;
      }
    }
  };
  const auto name_of = [](const std::array<Index, Dim>& place, Index layer) {
    Name name{};
    std::copy(place.begin(), place.end(), name.begin());
    name[Dim] = layer;
    return name;
  };
  std::array<Name, Dim> axes;
  for (std::size_t d = 0; d < Dim; ++d) axes[d] = step(d);
  for_each_place([&](const std::array<Index, Dim>& place) { add_block(name_of(place, 0), axes); });
  for (std::size_t side = 0; side < Dim; ++side) {
    std::array<Name, Dim> layered = axes;
    layered[side] = step(Dim);
    for (const Index position : {Index{0}, n})
      for (Index layer = 0; layer < m; layer += 2)
        for_each_place(
            [&](std::array<Index, Dim> place) {
              place[side] = position;
              add_block(name_of(place, layer), layered);
            },
            static_cast<Index>(side));
  }
  // Quadratic faces: those of the cut blocks. A mid node is a lattice point, its name the mean of two names.
  std::map<Index, Name> names;
  for (const auto& [name, index] : known) names.emplace(index, name);
  mesh.macros = add_mid_nodes<Dim>(block_simplices, [&](Index a, Index b) {
    Name mean = names[a];
    for (std::size_t i = 0; i <= Dim; ++i) mean[i] = (mean[i] + names[b][i]) / 2;
    return known.at(mean);
  });
  find_boundary(mesh);
  mesh.macros.clear();  // they leave out the centres of the blocks
  return mesh;
}

}  // namespace jampack
