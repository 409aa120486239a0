// SPDX-License-Identifier: MIT
#include <cmath>
#include <jampack/mesh/ball_mesh.hpp>
#include <jampack/mesh/disk_mesh.hpp>
#include <map>
#include <numbers>
#include <set>

#include "../catch.hpp"

using namespace jampack;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

template <int Dim>
Mesh<Dim> grain_mesh(Index wanted) {
  if constexpr (Dim == 2)
    return disk_mesh(wanted);
  else
    return ball_mesh(wanted);
}

/// Area vector (edge normal times length in 2D) of a flat face, outward.
template <int Dim>
Vector<Dim> area_vector(const Mesh<Dim>& mesh, const BoundaryFace<Dim>& face) {
  const Vector<Dim> a = mesh.nodes[face.node[0]], ab = mesh.nodes[face.node[1]] - a;
  if constexpr (Dim == 2)
    return {ab[1], -ab[0]};
  else
    return 0.5 * ab.cross(mesh.nodes[face.node[2]] - a);
}

/// The boundary as linear faces over all its nodes.
template <int Dim>
Array<BoundaryFace<Dim>> refined_faces(const Mesh<Dim>& mesh) {
  Array<BoundaryFace<Dim>> faces;
  for (const auto& face : mesh.faces) {
    const auto& n = face.node;
    if constexpr (Dim == 2) {
      faces.push_back({{n[0], n[2], -1}, 2});
      faces.push_back({{n[2], n[1], -1}, 2});
    } else {
      for (const auto& t : {std::array<std::size_t, 3>{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}})
        faces.push_back({{n[t[0]], n[t[1]], n[t[2]], -1, -1, -1}, 3});
    }
  }
  return faces;
}

}  // namespace

TEMPLATE_TEST_CASE_SIG("grain meshes: nodes on the sphere, positive cells, a closed boundary", "",
                       ((int Dim), Dim), 2, 3) {
  for (const Index wanted : {100, 400, 808, 3000, 6685}) {
    INFO("wanted cells " << wanted);
    const auto mesh = grain_mesh<Dim>(wanted);
    CHECK(mesh.cells.size() == mesh.macros.size() * Mesh<Dim>::n_cells_a_macro);
    double smallest = 1;
    for (const auto& cell : mesh.cells)
      smallest = std::min(smallest, simplex_determinant<Dim>(mesh.nodes, cell));
    CHECK(smallest > 0);

    const std::set<Index> boundary(mesh.boundary_nodes.begin(), mesh.boundary_nodes.end());
    double off_sphere = 0, deepest = 0;
    for (Index i = 0; i < mesh.nodes.size(); ++i)
      if (boundary.count(i))
        off_sphere = std::max(off_sphere, std::abs(mesh.nodes[i].norm() - 0.5));
      else
        deepest = std::max(deepest, mesh.nodes[i].norm());
    CHECK(off_sphere < 1e-15);
    CHECK(deepest < 0.5 - 1e-3);

    // Divergence theorem on the refined boundary: closed, outward, and around all of the volume.
    Vector<Dim> sum = Vector<Dim>::Zero();
    double enclosed = 0;
    for (const auto& face : refined_faces(mesh)) {
      const Vector<Dim> area = area_vector(mesh, face);
      sum += area;
      enclosed += area.dot(mesh.nodes[face.node[0]]) / Dim;
      CHECK(area.dot(mesh.nodes[face.node[0]]) > 0);
    }
    CHECK_THAT(sum.norm(), WithinAbs(0, 1e-13));
    CHECK_THAT(mesh_volume(mesh), WithinRel(enclosed, 1e-12));

    // Conforming: an edge (of linear cells) is never longer than the edges that meet on it, so that every
    // node that lies on the middle of an edge is a node of the cells about that edge. Counted by Euler's
    // formula.
    std::set<std::set<Index>> edges, triangles;
    for (const auto& cell : mesh.cells)
      for (std::size_t a = 0; a <= Dim; ++a)
        for (std::size_t b = 0; b < a; ++b) {
          edges.insert({cell[a], cell[b]});
          for (std::size_t c = 0; c < b; ++c) triangles.insert({cell[a], cell[b], cell[c]});
        }
    const Index euler = mesh.nodes.size() - static_cast<Index>(edges.size()) +
                        static_cast<Index>(triangles.size()) - (Dim == 3 ? mesh.cells.size() : 0);
    CHECK(euler == 1);
  }
}

TEMPLATE_TEST_CASE_SIG("grain meshes meet the wanted number of cells within 5 % and keep their shape", "",
                       ((int Dim), Dim), 2, 3) {
  double least = 1, least_mean = 1, least_jacobian = 1;
  for (Index wanted = Dim == 2 ? 80 : 350; wanted < 30000; wanted += 1 + wanted / 9) {
    INFO("wanted cells " << wanted);
    const auto mesh = grain_mesh<Dim>(wanted);
    CHECK(std::abs(static_cast<double>(mesh.cells.size() - wanted)) <= 0.05 * static_cast<double>(wanted));
    const auto quality = mesh_quality(mesh);
    least = std::min(least, quality.min_radius_ratio);
    least_mean = std::min(least_mean, quality.mean_radius_ratio);
    least_jacobian = std::min(least_jacobian, quality.min_scaled_jacobian);
  }
  CHECK(least > 0.30);
  CHECK(least_mean > 0.50);
  CHECK(least_jacobian > 0.20);
}

TEST_CASE("the sizes the programs use have well-shaped cells") {
  for (const Index wanted : {400, 808}) CHECK(mesh_quality(ball_mesh(wanted)).min_radius_ratio > 0.6);
  CHECK(mesh_quality(ball_mesh(6685)).min_radius_ratio > 0.5);
  CHECK(mesh_quality(disk_mesh(100)).min_radius_ratio > 0.4);
  CHECK(disk_mesh(100).boundary_nodes.size() >= 24);
}

TEMPLATE_TEST_CASE_SIG("volume and surface of the inscribed mesh converge at second order", "",
                       ((int Dim), Dim), 2, 3) {
  // Eight (four) times the cells is half the edge: a quarter of the error.
  const auto errors = [](Index cells) {
    const auto mesh = grain_mesh<Dim>(cells);
    double surface = 0;
    for (const auto& face : refined_faces(mesh)) surface += area_vector(mesh, face).norm();
    const double volume_error = 1 - mesh_volume(mesh) / ball_volume<Dim>(1);
    return std::array{volume_error, 1 - surface / std::numbers::pi};  // pi d, pi d^2
  };
  const Index fine = Dim == 2 ? 1600 : 3200;
  const auto coarse_error = errors(fine / (Dim == 2 ? 4 : 8)), fine_error = errors(fine);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(fine_error[i] > 0);
    CHECK_THAT(coarse_error[i] / fine_error[i], WithinAbs(4, 0.3));
  }
}

TEST_CASE("a mesh is the same every time, and too few cells are refused") {
  CHECK(ball_mesh(808).nodes == ball_mesh(808).nodes);
  CHECK(ball_mesh(808).cells == ball_mesh(808).cells);
  CHECK_THROWS_AS(ball_mesh(31), InvalidInput);
  CHECK_THROWS_AS(ball_mesh(-5), InvalidInput);
  CHECK_THROWS_AS(disk_mesh(63), InvalidInput);
}
