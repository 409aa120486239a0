// SPDX-License-Identifier: MIT
#include <Eigen/Dense>
#include <jampack/detection/grain_surface.hpp>
#include <jampack/mesh/ball_mesh.hpp>
#include <jampack/mesh/disk_mesh.hpp>

#include "audited.hpp"

using namespace jampack;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using jampack_tests::audit_of;

namespace {

template <int Dim>
Mesh<Dim> grain_mesh(Index cells) {
  if constexpr (Dim == 2)
    return disk_mesh(cells);
  else
    return ball_mesh(cells);
}

template <int Dim>
Box<Dim> cube(double edge) {
  return {Vector<Dim>::Constant(-edge / 2), Vector<Dim>::Constant(edge / 2)};
}

/// Undeformed grains at rest, no contact stored.
template <int Dim>
StoredState<Dim> placed(Index cells, const Array<std::pair<double, Vector<Dim>>>& grains, double room = 10) {
  StoredState<Dim> state;
  state.element = "macro";
  state.material = "neo_hookean";
  state.mesh = grain_mesh<Dim>(cells);
  state.room = container(cube<Dim>(room));
  for (const auto& [d, centre] : grains) {
    StoredGrain<Dim> grain;
    grain.diameter = d;
    grain.position.resize(Dim, state.mesh.nodes.size());
    for (Index i = 0; i < state.mesh.nodes.size(); ++i)
      grain.position.col(i) = centre + d * state.mesh.nodes[i];
    grain.velocity = 0 * grain.position;
    grain.position_before = grain.position;
    grain.velocity_before = grain.velocity;
    state.grains.push_back(grain);
  }
  return state;
}

}  // namespace

TEST_CASE("overlap of two undeformed grains is that of the lens") {
  const double depth = 0.03, between = 1 - depth;
  const auto disks = audit_of(placed<2>(400, {{1.0, {0, 0}}, {1.0, {between, 0}}}));
  const double lens_2d = 0.5 * std::acos(between) - between / 2 * std::sqrt(1 - between * between);
  CHECK_THAT(disks.max_penetration_over_d, WithinRel(depth, 0.02));
  CHECK_THAT(disks.overlap_over_solid, WithinRel(lens_2d / (std::numbers::pi / 2), 0.05));
  CHECK(disks.n_missed > 0);

  const Vector<3> along = Vector<3>(1, 2, -1).normalized();
  const auto balls = audit_of(placed<3>(800, {{1.0, Vector<3>::Zero()}, {1.0, between * along}}));
  const double lens_3d = std::numbers::pi / 12 * (2 + between) * depth * depth;
  CHECK_THAT(balls.max_penetration_over_d, WithinRel(depth, 0.1));
  CHECK_THAT(balls.overlap_over_solid, WithinRel(lens_3d / (std::numbers::pi / 3), 0.1));
  CHECK_THAT(balls.solid_volume, WithinRel(std::numbers::pi / 3, 2e-3));
  CHECK_THAT(balls.packing_fraction, WithinRel(balls.solid_volume / 1000, 1e-12));
  CHECK_FALSE(balls.is_good());
}

TEST_CASE("grains apart show no penetration, a grain within another its full depth") {
  const auto apart = audit_of(placed<3>(100, {{1.0, {0, 0, 0}}, {1.0, {1.001, 0, 0}}}));
  CHECK(apart.max_penetration_over_d == 0);
  CHECK(apart.overlap_over_solid == 0);
  CHECK(apart.is_good());
  const auto within = audit_of(placed<2>(100, {{1.0, {0, 0}}, {0.2, {0.05, 0}}}));
  CHECK(within.max_penetration_over_d > 0.3);
}

TEST_CASE("a grain beyond a wall penetrates it by as much") {
  const auto report = audit_of(placed<2>(400, {{1.0, {4.52, 0}}}));
  CHECK_THAT(report.max_penetration_over_d, WithinRel(0.02, 0.02));
  const double r = 0.5, c = 0.48, segment = r * r * std::acos(c / r) - c * std::sqrt(r * r - c * c);
  CHECK_THAT(report.overlap_over_solid, WithinRel(segment / (std::numbers::pi / 4), 0.05));
}

TEST_CASE("a grain bent into a ring touches itself when its ends overlap") {
  for (const double turns : {0.9, 1.05}) {
    auto state = placed<2>(400, {{1.0, {0, 0}}});
    auto& x = state.grains[0].position;
    for (Index i = 0; i < x.cols(); ++i) {
      const double angle = 2 * std::numbers::pi * turns * x(0, i), radius = 1 - 0.2 * x(1, i);
      x.col(i) << radius * std::cos(angle), radius * std::sin(angle);
    }
    const auto report = audit_of(state);
    CHECK((report.self_penetration_over_d > 5e-3) == (turns > 1));
    CHECK(report.is_good() == false);  // nothing holds it in this shape
  }
}

TEST_CASE("the audit's projection is that of its definition, and the detection's") {
  auto state = placed<3>(100, {{1.0, {0, 0, 0}}});
  auto& x = state.grains[0].position;
  for (Index i = 0; i < x.cols(); ++i) x(0, i) *= 1 + 0.3 * x(1, i);  // no symmetry left
  const AuditSurface<3> surface(state.mesh, x);
  const auto boundary = make_boundary(state.mesh);
  GrainSurface<3> other;
  other.update(boundary, x, 1.0);
  Index n_found = 0;
  for (int k = 0; k < 200; ++k) {
    const Vector<3> along(std::cos(3.7 * k), std::sin(5.1 * k), std::cos(1.3 * k + 1));
    const Vector<3> point = (0.49 + 0.02 * std::sin(k)) * along.normalized();
    const auto p = surface.project(point, 0.2);
    REQUIRE(p.face >= 0);
    const auto q = other.project(point);
    if (!q.on_surface) continue;
    ++n_found;
    CHECK_THAT(p.gap, WithinAbs(q.gap, 1e-10));
    CHECK((p.normal - q.normal).norm() < 1e-9);
    CHECK((other.point(p.face, p.xi) + p.gap * p.normal - point).norm() < 1e-10);
  }
  CHECK(n_found > 190);
}

TEST_CASE("compliances of coupled nodes are entries of the inverse tangent") {
  const auto state = placed<3>(64, {{1.0, {0, 0, 0}}});
  const auto& x = state.grains[0].position;
  using Element = MacroSimplex<3>;
  const NeoHookean material{1, 0.4, 1};
  const auto cells = Element::cells(state.mesh, 1, Matrix<3>::Identity());
  const Eigen::VectorXd mass = Eigen::VectorXd::LinSpaced(x.cols(), 0.01, 0.02);
  const double theta = 0.8, h = 1.3;
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(3 * x.cols(), 3 * x.cols());
  for (const auto& cell : cells) {
    Element::Nodal local, f;
    Element::Tangent k;
    for (int i = 0; i < Element::n_nodes; ++i) local.col(i) = x.col(cell.node[std::size_t(i)]);
    REQUIRE(Element::force_and_tangent(cell, material, local, f, k));
    for (int i = 0; i < 3 * Element::n_nodes; ++i)
      for (int j = 0; j < 3 * Element::n_nodes; ++j)
        a(3 * cell.node[std::size_t(i / 3)] + i % 3, 3 * cell.node[std::size_t(j / 3)] + j % 3) +=
            theta * k(i, j);
  }
  for (Index i = 0; i < a.rows(); ++i) a(i, i) += mass[i / 3] / (theta * h * h);
  const Eigen::MatrixXd inverse = a.inverse();
  const AuditCompliance<Element, NeoHookean, 3> compliance(state.mesh, cells, material, x, mass, theta, h);
  REQUIRE(compliance.is_usable());
  double error = 0;
  for (const auto& face : state.mesh.faces)
    for (Index i = 0; i < face.n_nodes; ++i)
      for (Index j = 0; j < face.n_nodes; ++j)
        for (int p = 0; p < 3; ++p)
          for (int q = 0; q < 3; ++q) {
            const Index m = face.node[std::size_t(i)], n = face.node[std::size_t(j)];
            error = std::max(error, std::abs(compliance.entry(m, p, n, q) - inverse(3 * m + p, 3 * n + q)));
          }
  CHECK(error < 1e-10 * inverse.diagonal().maxCoeff());
}
