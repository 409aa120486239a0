// SPDX-License-Identifier: MIT
#include <jampack/solver/gauss_seidel.hpp>
#include <jampack/stepping/moreau_rigid.hpp>
#include <numbers>

#include "../catch.hpp"

using namespace jampack;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

const GaussSeidel tight{{1e-14, 100000}};

template <int Dim>
RigidWalls<Dim> no_walls() {
  return {};
}

// The ground y = 0 (z = 0 in 3D), its normal up.
template <int Dim>
RigidWalls<Dim> ground() {
  RigidWalls<Dim> walls;
  walls.room.normal.push_back(Vector<Dim>::Unit(Dim - 1));
  walls.room.distance.push_back(0.0);
  return walls;
}

}  // namespace

TEMPLATE_TEST_CASE_SIG("Two balls that meet head on stay together with the common velocity", "",
                       ((int Dim), Dim), 2, 3) {
  const double theta = GENERATE(0.5, 0.75, 1.0);
  Balls<Dim> balls;
  balls.add(1.0, -0.5005 * Vector<Dim>::UnitX());
  balls.add(2.0, 1.0005 * Vector<Dim>::UnitX());
  auto bodies = rigid_balls(balls, 3.0);
  bodies.velocity[0] = 2.0 * Vector<Dim>::UnitX();
  bodies.velocity[1] = -1.0 * Vector<Dim>::UnitX();
  auto walls = no_walls<Dim>();
  const Vector<Dim> before = bodies.momentum();
  const double common = before[0] / bodies.total_mass();
  MoreauRigid<Dim, Signorini> stepping(Signorini{}, {.theta = theta});
  for (int k = 0; k < 10; ++k) REQUIRE(stepping.step(bodies, walls, 1e-3, tight).accepted);
  // theta < 1 leaves the remainder of g/(theta h) after the step that closes the gap; it dies out as (1/theta
  // - 1)^k.
  if (theta == 1.0) {
    CHECK_THAT(bodies.velocity[0][0], WithinAbs(common, 1e-12));
    CHECK_THAT(bodies.velocity[1][0], WithinAbs(common, 1e-12));
    const double gap = (bodies.balls.position[1] - bodies.balls.position[0]).norm() - 1.5;
    CHECK_THAT(gap, WithinAbs(0.0, 1e-12));
  }
  CHECK_THAT((bodies.momentum() - before).norm(), WithinAbs(0.0, 1e-12 * before.norm()));
}

TEMPLATE_TEST_CASE_SIG("Frictional collisions conserve momentum and never add energy", "", ((int Dim), Dim),
                       2, 3) {
  Balls<Dim> balls;
  for (int i = 0; i < 5; ++i) {
    Vector<Dim> x = 1.02 * i * Vector<Dim>::UnitX();
    x[1] = 0.3 * (i % 2);
    balls.add(1.0 + 0.01 * i, x);
  }
  auto bodies = rigid_balls(balls, 1.0);
  for (int i = 0; i < 5; ++i) {
    bodies.velocity[i] = Vector<Dim>::Constant(0.1 * i);
    bodies.velocity[i][0] = 2.0 - i;
    bodies.spin[i].setConstant(0.5 * i - 1.0);
  }
  auto walls = no_walls<Dim>();
  const Vector<Dim> momentum = bodies.momentum();
  const Spin<Dim> angular = bodies.angular_momentum();
  MoreauRigid<Dim> stepping(SignoriniCoulomb{0.4});
  double energy = bodies.kinetic_energy();
  const double first = energy;
  for (int k = 0; k < 500; ++k) {
    REQUIRE(stepping.step(bodies, walls, 1e-3, tight).accepted);
    // The gap in the condition may give back r_N |g| where g < 0 (physics: contact work bound).
    double bound = 0.0;
    for (const auto& entry : stepping.forces())
      bound += 1e-3 * entry.force.norm() * std::max(0.0, -entry.contact.gap) / 1e-3;
    CHECK(bodies.kinetic_energy() <= energy + bound + 1e-12 * first);
    energy = bodies.kinetic_energy();
  }
  CHECK(energy < 0.9 * first);
  CHECK_THAT((bodies.momentum() - momentum).norm(), WithinAbs(0.0, 1e-12));
  // Forces act along and at the contact point the step saw; the balls then move by h v, so that angular
  // momentum is exact to the length by which contact points part, of order the gap.
  CHECK_THAT((bodies.angular_momentum() - angular).norm(), WithinAbs(0.0, 5e-3 * angular.norm()));
}

TEMPLATE_TEST_CASE_SIG("A sliding ball comes to roll at 5/7 (sphere) or 2/3 (disk) of its first speed", "",
                       ((int Dim), Dim), 2, 3) {
  const double gravity = 9.81, friction = 0.2, start = 1.5;
  Balls<Dim> balls;
  balls.add(0.1, 0.05 * Vector<Dim>::Unit(Dim - 1));
  auto bodies = rigid_balls(balls, 2500.0);
  bodies.velocity[0][0] = start;
  bodies.force[0] = -bodies.mass[0] * gravity * Vector<Dim>::Unit(Dim - 1);
  auto walls = ground<Dim>();
  MoreauRigid<Dim> stepping(SignoriniCoulomb{0.0}, {.wall_friction = friction});
  const double h = 1e-3;
  const double factor = Dim == 3 ? 5.0 / 7.0 : 2.0 / 3.0;
  const double until = (1.0 - factor) * start / (friction * gravity);  // slides until then
  const auto steps = static_cast<int>(std::floor(until / h));
  for (int k = 0; k < steps; ++k) REQUIRE(stepping.step(bodies, walls, h, tight).accepted);
  CHECK_THAT(bodies.velocity[0][0], WithinRel(start - friction * gravity * h * steps, 1e-10));
  for (int k = 0; k < 20; ++k) REQUIRE(stepping.step(bodies, walls, h, tight).accepted);
  CHECK_THAT(bodies.velocity[0][0], WithinRel(factor * start, 1e-10));
  // Rolling: the contact point is at rest.
  const Vector<Dim> contact =
      bodies.velocity[0] + spin_cross<Dim>(bodies.spin[0], Vector<Dim>(-0.05 * Vector<Dim>::Unit(Dim - 1)));
  CHECK_THAT(contact.norm(), WithinAbs(0.0, 1e-10));
  CHECK_THAT(bodies.balls.position[0][Dim - 1], WithinAbs(0.05, 1e-12));
}

TEMPLATE_TEST_CASE_SIG("A stack under its weight and a push carries the exact forces", "", ((int Dim), Dim),
                       2, 3) {
  Balls<Dim> balls;
  const int n = 6;
  for (int i = 0; i < n; ++i) balls.add(1.0, (i + 0.5) * Vector<Dim>::Unit(Dim - 1));
  auto bodies = rigid_balls(balls, 1.0);
  const double weight = 0.7 * bodies.mass[0], push = 3.0;
  for (auto& force : bodies.force) force = -weight * Vector<Dim>::Unit(Dim - 1);
  bodies.force[n - 1] -= push * Vector<Dim>::Unit(Dim - 1);
  auto walls = ground<Dim>();
  MoreauRigid<Dim, Signorini> stepping(Signorini{});
  REQUIRE(stepping.step(bodies, walls, 0.01, tight).solve.converged);
  int counted = 0;
  for (const auto& [gap, force] : stepping.forces()) {
    if (force.isZero(0.0)) continue;
    ++counted;
    const double carried = static_cast<double>(n - gap.candidate) * weight + push;
    CHECK_THAT(force[Dim - 1], WithinRel(carried, 1e-9));
    CHECK_THAT(force.norm(), WithinRel(carried, 1e-9));
  }
  CHECK(counted == n);
  CHECK_THAT(bodies.kinetic_energy(), WithinAbs(0.0, 1e-20));
}

TEST_CASE("Penetration at the start is pushed out once and does not come back") {
  Balls<3> balls;
  balls.add(1.0, {0, 0, 0});
  balls.add(1.0, {0.99, 0, 0});
  auto bodies = rigid_balls(balls, 1.0);
  auto walls = no_walls<3>();
  MoreauRigid<3, Signorini> stepping(Signorini{}, {.drag_time = 1.0});
  REQUIRE(stepping.step(bodies, walls, 0.1, tight).accepted);
  CHECK_THAT((bodies.balls.position[1] - bodies.balls.position[0]).norm(), WithinAbs(1.0, 1e-12));
}

TEMPLATE_TEST_CASE_SIG("Walls driven by velocity carry a ball with them", "", ((int Dim), Dim), 2, 3) {
  Balls<Dim> balls;
  balls.add(1.0, Vector<Dim>::Zero());
  auto bodies = rigid_balls(balls, 1.0);
  Box<Dim> box{Vector<Dim>::Constant(-1.0), Vector<Dim>::Constant(1.0)};
  bodies.balls.position[0][0] = 0.5;  // touches the upper x wall
  RigidWalls<Dim> walls{container(box)};
  walls.scale_rate = -0.25;
  MoreauRigid<Dim, Signorini> stepping(Signorini{});
  for (int k = 0; k < 10; ++k) REQUIRE(stepping.step(bodies, walls, 0.01, tight).accepted);
  CHECK_THAT(bodies.velocity[0][0], WithinAbs(-0.25, 1e-12));
  CHECK_THAT(bodies.balls.position[0][0], WithinAbs(0.475, 1e-12));
  CHECK_THAT(walls.room.scale, WithinAbs(0.975, 1e-12));
  CHECK(walls.scale_rate == -0.25);
}

TEMPLATE_TEST_CASE_SIG("Walls driven by stress close a filled box until each carries stress times area", "",
                       ((int Dim), Dim), 2, 3) {
  Balls<Dim> balls;
  balls.add(1.0, Vector<Dim>::Constant(0.01));
  auto bodies = rigid_balls(balls, 1.0);
  RigidWalls<Dim> walls{container(centred_cube<Dim>(1.1))};
  MoreauRigid<Dim, Signorini> stepping(Signorini{});
  const double stress = 2.5;
  for (int k = 0; k < 60; ++k) {
    drive_by_stress(walls, stress, bodies.total_mass());
    REQUIRE(stepping.step(bodies, walls, 0.01, tight).accepted);
  }
  CHECK_THAT(walls.room.volume(), WithinRel(1.0, 1e-9));
  double carried = 0.0;
  for (const auto& entry : stepping.forces()) carried += entry.force.norm();
  CHECK_THAT(carried, WithinRel(2 * Dim * stress, 1e-9));
}

TEST_CASE("A spinning ball keeps its rotation for the handover") {
  Balls<3> balls;
  balls.add(1.0, Vector<3>::Zero());
  auto bodies = rigid_balls(balls, 1.0);
  bodies.spin[0] = Vector<3>(0.0, 0.0, std::numbers::pi);
  auto walls = no_walls<3>();
  MoreauRigid<3> stepping(SignoriniCoulomb{0.3});
  for (int k = 0; k < 50; ++k) stepping.step(bodies, walls, 0.01, tight);
  const Vector<3> turned_x = rotation_matrix<3>(bodies.balls.orientation[0]) * Vector<3>::UnitX();
  CHECK_THAT((turned_x - Vector<3>::UnitY()).norm(), WithinAbs(0.0, 1e-12));
}

TEST_CASE("A step that would carry a ball too far is refused and changes nothing") {
  Balls<2> balls;
  balls.add(1.0, Vector<2>::Zero());
  auto bodies = rigid_balls(balls, 1.0);
  bodies.velocity[0] = {1.0, 0.0};
  auto walls = no_walls<2>();
  MoreauRigid<2> stepping(SignoriniCoulomb{0.3});
  CHECK_FALSE(stepping.step(bodies, walls, 1.0, tight).accepted);
  CHECK(bodies.balls.position[0] == Vector<2>::Zero());
  bodies.velocity[0][0] = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(stepping.step(bodies, walls, 0.01, tight), Error);
}

TEST_CASE("Impossible parameters of the step are refused with a line that names them") {
  CHECK_THROWS_WITH(MoreauRigid<3>(SignoriniCoulomb{-0.1}), jampack_tests::contains("friction"));
  CHECK_THROWS_WITH(MoreauRigid<3>(SignoriniCoulomb{std::nan("")}), jampack_tests::contains("friction"));
  CHECK_THROWS_WITH(MoreauRigid<3>(SignoriniCoulomb{0.1}, {.theta = 0.4}), jampack_tests::contains("theta"));
  CHECK_THROWS_WITH((MoreauRigid<3, HertzCheck>(HertzCheck{.young = -1})), jampack_tests::contains("Young"));
}

TEST_CASE("A contact without friction carries one unknown, with friction one a dimension") {
  STATIC_REQUIRE(MoreauRigid<3, Signorini>::Problem::n_unknowns == 1);
  STATIC_REQUIRE(MoreauRigid<2, Signorini>::Problem::n_unknowns == 1);
  STATIC_REQUIRE(MoreauRigid<3, SignoriniCoulomb>::Problem::n_unknowns == 3);
  STATIC_REQUIRE(MoreauRigid<2, SignoriniCoulomb>::Problem::n_unknowns == 2);
}
