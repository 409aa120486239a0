// SPDX-License-Identifier: MIT
#include <cmath>
#include <jampack/element/brick.hpp>
#include <jampack/mesh/brick_mesh.hpp>
#include <set>

#include "../catch.hpp"

using namespace jampack;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

TEMPLATE_TEST_CASE_SIG("brick meshes: every node used, boundary on the sphere, cells and bricks fill it", "",
                       ((int Dim), Dim), 2, 3) {
  for (const auto& [n_core, n_layers] : {std::array<Index, 2>{1, 1}, {2, 1}, {2, 2}, {3, 2}}) {
    INFO(n_core << " blocks a side, " << n_layers << " layers");
    const BrickMeshShape shape{.n_core = n_core, .n_layers = n_layers};
    const auto mesh = brick_mesh<Dim>(shape);
    CHECK(mesh.bricks.size() == shape.n_bricks(Dim));
    CHECK(mesh.cells.size() == mesh.bricks.size() * (Dim == 2 ? 2 : 5));
    const Index n = 2 * n_core + 1, m = 2 * n_layers;
    const Index n_surface = Dim == 2 ? 4 * (n - 1) : n * n * n - (n - 2) * (n - 2) * (n - 2);
    CHECK(mesh.nodes.size() == (Dim == 2 ? n * n : n * n * n) + m * n_surface);
    CHECK(mesh.boundary_nodes.size() == n_surface);
    std::set<Index> used, used_by_bricks;
    for (const auto& cell : mesh.cells) {
      CHECK(simplex_determinant<Dim>(mesh.nodes, cell) > 0);
      used.insert(cell.begin(), cell.end());
    }
    for (const auto& brick : mesh.bricks) used_by_bricks.insert(brick.begin(), brick.end());
    CHECK(static_cast<Index>(used.size()) == mesh.nodes.size());
    CHECK(used == used_by_bricks);
    for (const Index i : mesh.boundary_nodes) CHECK_THAT(mesh.nodes[i].norm(), WithinAbs(0.5, 1e-15));
    // The faces, as flat ones over all their nodes, enclose nearly the volume of the cells: they cut the
    // quadrilaterals of the boundary along other diagonals than the cells do.
    double enclosed = 0;
    Vector<Dim> sum = Vector<Dim>::Zero();
    for (const auto& face : mesh.faces) {
      const auto add = [&](const auto&... local) {
        const std::array<Vector<Dim>, Dim> x{mesh.nodes[face.node[local]]...};
        Vector<Dim> area;
        if constexpr (Dim == 2)
          area = {x[1][1] - x[0][1], x[0][0] - x[1][0]};
        else
          area = (x[1] - x[0]).cross(x[2] - x[0]) / 2;
        sum += area;
        enclosed += x[0].dot(area) / Dim;
      };
      using N = std::size_t;
      if constexpr (Dim == 2) {
        add(N{0}, N{2});
        add(N{2}, N{1});
      } else {
        add(N{0}, N{3}, N{5});
        add(N{3}, N{1}, N{4});
        add(N{5}, N{4}, N{2});
        add(N{3}, N{4}, N{5});
      }
    }
    CHECK_THAT(sum.norm(), WithinAbs(0, 1e-14));
    CHECK_THAT(enclosed, WithinRel(mesh_volume(mesh), Dim == 2 ? 1e-12 : 0.02));
    double volume = 0;
    for (const auto& cell : Brick<Dim>::cells(mesh, 1.0, Matrix<Dim>::Identity())) volume += cell.volume;
    CHECK_THAT(volume, WithinRel(mesh_volume(mesh), Dim == 2 ? 1e-12 : 0.02));
  }
}

TEST_CASE("brick meshes: what is refused") {
  CHECK_THROWS_AS(brick_mesh<3>({.n_core = 0, .n_layers = 1}), InvalidInput);
  CHECK_THROWS_AS(brick_mesh<2>({.n_core = 1, .n_layers = 0}), InvalidInput);
}
