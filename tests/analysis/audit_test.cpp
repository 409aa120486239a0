// SPDX-License-Identifier: MIT
#include <Eigen/Dense>
#include <jampack/analysis/audit.hpp>
#include <jampack/detection/grain_surface.hpp>
#include <jampack/element/linear_simplex.hpp>
#include <jampack/element/macro_simplex.hpp>
#include <jampack/io/checkpoint_compaction.hpp>
#include <jampack/law/signorini_coulomb.hpp>
#include <jampack/mesh/ball_mesh.hpp>
#include <jampack/mesh/disk_mesh.hpp>

#include "../catch.hpp"

using namespace jampack;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

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

template <int Dim>
AuditReport audit_of(const StoredState<Dim>& state) {
  return audit<MacroSimplex<Dim>, NeoHookean>(state);
}

/// Grains of several sizes pressed in a box until they have this packing fraction.
template <int Dim, class Law = SignoriniCoulomb>
StoredState<Dim> pressed(Index cells, const Array<std::pair<double, Vector<Dim>>>& grains, double room,
                         double packing_fraction, double theta, Law law = {0.3}) {
  using Packing = SoftPacking<Dim, MacroSimplex<Dim>, NeoHookean>;
  Packing packing(grain_mesh<Dim>(cells), NeoHookean{1, 0.45, 1}, container(cube<Dim>(room)));
  for (const auto& [d, centre] : grains) packing.add(d, centre);
  SoftStepOptions step;
  step.theta = theta;
  Compaction<Packing, Law> compaction(std::move(packing), law, {.settled_afresh = 1e-5}, step);
  while (compaction.packing_fraction() < packing_fraction) compaction.advance();
  REQUIRE(compaction.settle());
  return stored_state(compaction);
}

const Array<std::pair<double, Vector<2>>> four_disks = {
    {1.0, {-0.52, -0.5}}, {0.95, {0.5, -0.5}}, {1.05, {0.48, 0.51}}, {0.98, {-0.55, 0.53}}};

StoredState<2> pressed_disks(double theta = 1) {
  return pressed<2>(64, four_disks, 2.12, 0.83, theta);
}

template <int Dim>
StoredContact<Dim>& strongest(Array<StoredContact<Dim>>& contacts) {
  Index best = 0;
  for (Index c = 0; c < contacts.size(); ++c)
    if (contacts[c].reaction.norm() > contacts[best].reaction.norm()) best = c;
  REQUIRE(contacts[best].reaction.norm() > 0);
  return contacts[best];
}

}  // namespace

TEST_CASE("the audit passes a pressed packing of disks and sees what is tampered with") {
  static const StoredState<2> good = pressed_disks();
  auto state = good;
  const AuditBounds bounds;
  SECTION("as it is") {
    const AuditReport report = audit_of(state);
    for (const auto& row : report.rows()) {
      INFO(row.name << " = " << row.value);
      CHECK(row.is_good);
    }
    CHECK(report.equilibrium_residual < 1e-5);
    CHECK(report.n_contact_points > 10);
    CHECK(report.pressure > 0);
    CHECK(report.coordination >= 1.5);
  }
  SECTION("a reaction is too large") {
    strongest(state.pairs).reaction *= 1.1;
    CHECK(audit_of(state).equilibrium_residual > bounds.equilibrium_residual);
  }
  SECTION("a contact is removed: no balance, neither of its grains") {
    strongest(state.pairs).reaction.setZero();
    const AuditReport report = audit_of(state);
    CHECK(report.equilibrium_residual > bounds.equilibrium_residual);
    CHECK(report.grain_imbalance > bounds.grain_imbalance);
  }
  SECTION("a wall force is removed: the walls do not balance") {
    strongest(state.walls).reaction.setZero();
    CHECK(audit_of(state).wall_imbalance > bounds.wall_imbalance);
  }
  SECTION("a reaction leaves the cone") {
    auto& reaction = strongest(state.pairs).reaction;
    const Vector<2> across(-reaction[1], reaction[0]);
    reaction += across;
    CHECK(audit_of(state).scaled_residual > 1e-2);
  }
  SECTION("a reaction pulls") {
    strongest(state.pairs).reaction *= -1;
    CHECK(audit_of(state).scaled_residual > 1e-2);
  }
  SECTION("a friction force with no slip against it: the friction coefficient is smaller than was used") {
    state.friction = 0.01;
    CHECK(audit_of(state).scaled_residual > bounds.scaled_residual);
  }
  SECTION("a grain is shifted into another") {
    state.grains[0].position.row(0).array() += 0.02;
    const AuditReport report = audit_of(state);
    CHECK(report.max_penetration_over_d > bounds.max_penetration_over_d);
    CHECK(report.max_penetration_over_d < 0.03);
    CHECK(report.scaled_residual > bounds.scaled_residual);
    CHECK(report.kinematic_error > bounds.kinematic_error);
    CHECK(report.n_missed >= 0);
  }
  SECTION("a velocity is not that of the motion") {
    state.grains[1].velocity(0, 0) += 1e-3;
    CHECK(audit_of(state).kinematic_error > bounds.kinematic_error);
  }
  SECTION("a cell is inverted") {
    const auto& cell = state.mesh.cells[0];
    auto& x = state.grains[2].position;
    x.col(cell[0]).swap(x.col(cell[1]));
    const AuditReport report = audit_of(state);
    CHECK(report.min_jacobian <= 0);
    CHECK_FALSE(report.is_good());
  }
  SECTION("the element is another") {
    CHECK_THROWS_AS((audit<LinearSimplex<2>, NeoHookean>(state)), InvalidInput);
  }
}

TEST_CASE("the audit passes steps of any theta, and knows which theta it was") {
  auto state = pressed_disks(0.6);
  CHECK(audit_of(state).is_good());
  state.theta = 0.7;
  CHECK_FALSE(audit_of(state).is_good());
}

TEST_CASE("the audit passes disks without friction, whose forces turn with the faces") {
  auto state = pressed<2>(64, four_disks, 2.12, 0.9, 1, Signorini{});
  REQUIRE(state.n_pair_unknowns == 1);
  const AuditReport report = audit_of(state);
  for (const auto& row : report.rows()) {
    INFO(row.name << " = " << row.value);
    CHECK(row.is_good);
  }
  strongest(state.pairs).reaction *= 1.1;
  CHECK_FALSE(audit_of(state).is_good());
}

TEST_CASE("the audit passes spheres, and sees a contact removed") {
  auto state = pressed<3>(400, {{1.0, {-0.3, -0.28, -0.25}}, {0.9, {0.32, 0.33, 0.29}}}, 1.64, 0.35, 1);
  const AuditReport report = audit_of(state);
  for (const auto& row : report.rows()) {
    INFO(row.name << " = " << row.value);
    CHECK(row.is_good);
  }
  CHECK(report.n_contact_points >= 7);
  strongest(state.pairs).reaction.setZero();
  CHECK(audit_of(state).equilibrium_residual > 1e-2);
}

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
