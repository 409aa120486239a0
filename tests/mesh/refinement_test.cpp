// SPDX-License-Identifier: MIT
#include <jampack/mesh/quality.hpp>
#include <jampack/mesh/refinement.hpp>

#include "../catch.hpp"

using namespace jampack;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

/// One macro of straight edges with corners of no symmetry.
template <int Dim>
Mesh<Dim> one_macro() {
  Mesh<Dim> mesh;
  Eigen::Matrix<double, 3, 4> corners;
  corners << 0.1, 1.3, -0.2, 0.4, 0.0, 0.2, 1.1, 0.3, -0.1, 0.1, 0.2, 0.9;
  for (int i = 0; i <= Dim; ++i) mesh.nodes.push_back(corners.col(i).template head<Dim>());
  Array<std::array<Index, Dim + 1>> simplices(1);
  for (std::size_t i = 0; i <= Dim; ++i) simplices[0][i] = static_cast<Index>(i);
  mesh.macros = add_mid_nodes<Dim>(simplices, [&](Index a, Index b) {
    mesh.nodes.push_back(0.5 * (mesh.nodes[a] + mesh.nodes[b]));
    return mesh.nodes.size() - 1;
  });
  mesh.cells = refine_macros<Dim>(mesh.nodes, mesh.macros);
  return mesh;
}

}  // namespace

TEMPLATE_TEST_CASE_SIG("refinement along every diagonal fills the macro with cells of equal volume", "",
                       ((int Dim), Dim), 2, 3) {
  const auto mesh = one_macro<Dim>();
  std::array<Index, Dim + 1> corners;
  for (std::size_t i = 0; i <= Dim; ++i) corners[i] = mesh.macros[0][i];
  const double whole = simplex_determinant<Dim>(mesh.nodes, corners);
  for (int diagonal = 0; diagonal < (Dim == 2 ? 1 : 3); ++diagonal)
    for (const auto& local : macro_refinement<Dim>(diagonal)) {
      std::array<Index, Dim + 1> cell;
      for (std::size_t i = 0; i <= Dim; ++i) cell[i] = mesh.macros[0][static_cast<std::size_t>(local[i])];
      CHECK_THAT(simplex_determinant<Dim>(mesh.nodes, cell),
                 WithinRel(whole / Mesh<Dim>::n_cells_a_macro, 1e-12));
    }
}

TEST_CASE("the octahedron is cut along the diagonal whose worst cell is best") {
  const auto mesh = one_macro<3>();
  const auto worst = [&](const auto& cells) {
    double ratio = 1;
    for (const auto& cell : cells) ratio = std::min(ratio, radius_ratio<3>(mesh.nodes, cell));
    return ratio;
  };
  for (int diagonal = 0; diagonal < 3; ++diagonal) {
    auto cells = refine_macro<3>(mesh.nodes, mesh.macros[0]);
    const auto local = macro_refinement<3>(diagonal);
    for (std::size_t c = 0; c < local.size(); ++c)
      for (std::size_t i = 0; i < 4; ++i) cells[c][i] = mesh.macros[0][static_cast<std::size_t>(local[c][i])];
    CHECK(worst(mesh.cells) >= worst(cells));
  }
}

TEST_CASE("radius ratio: 1 for regular simplices, closed form for right-angled ones") {
  const double h = std::sqrt(3.0) / 2;
  const Array<Vector<2>> regular{{0, 0}, {1, 0}, {0.5, h}}, right{{0, 0}, {1, 0}, {0, 1}};
  CHECK_THAT(radius_ratio<2>(regular, {0, 1, 2}), WithinRel(1.0, 1e-14));
  CHECK_THAT(radius_ratio<2>(regular, {1, 0, 2}), WithinRel(-1.0, 1e-14));
  // Right isosceles: r = 1 - 1/sqrt 2, R = 1/sqrt 2.
  CHECK_THAT(radius_ratio<2>(right, {0, 1, 2}), WithinRel(2 * (std::sqrt(2.0) - 1), 1e-14));
  const Array<Vector<3>> cube{{0, 0, 0}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  CHECK_THAT(std::abs(radius_ratio<3>(cube, {0, 1, 2, 3})), WithinRel(1.0, 1e-14));
  // Corner of a cube: r = 1 / (3 + sqrt 3), R = sqrt 3 / 2.
  CHECK_THAT(radius_ratio<3>(cube, {0, 4, 5, 6}),
             WithinRel(3 * 2 / (3 + std::sqrt(3.0)) / std::sqrt(3.0), 1e-14));
}

TEMPLATE_TEST_CASE_SIG("the Jacobian of a macro is that of its corners when edges are straight", "",
                       ((int Dim), Dim), 2, 3) {
  auto mesh = one_macro<Dim>();
  CHECK_THAT(mesh_quality(mesh).min_scaled_jacobian, WithinRel(1.0, 1e-12));
  // A mid node moved past the quarter point makes the map fold at the nearer corner.
  const auto& macro = mesh.macros[0];
  mesh.nodes[macro[Dim + 1]] = 0.76 * mesh.nodes[macro[0]] + 0.24 * mesh.nodes[macro[1]];
  CHECK(macro_jacobian_range<Dim>(mesh.nodes, macro).first < 0);
  mesh.nodes[macro[Dim + 1]] = 0.74 * mesh.nodes[macro[0]] + 0.26 * mesh.nodes[macro[1]];
  CHECK(macro_jacobian_range<Dim>(mesh.nodes, macro).first > 0);
}
