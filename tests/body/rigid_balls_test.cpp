// SPDX-License-Identifier: MIT
#include <jampack/body/rigid_balls.hpp>
#include <jampack/body/rigid_walls.hpp>
#include <numbers>

#include "../catch.hpp"

using namespace jampack;
using Catch::Matchers::WithinRel;

TEST_CASE("Mass and inertia are those of homogeneous spheres and disks") {
  Balls<3> spheres;
  spheres.add(2.0, Vector<3>::Zero());
  const auto sphere = rigid_balls(spheres, 3.0);
  CHECK_THAT(sphere.mass[0], WithinRel(4 * std::numbers::pi, 1e-15));
  CHECK_THAT(sphere.inertia[0], WithinRel(0.4 * sphere.mass[0], 1e-15));  // 2/5 m R^2
  Balls<2> disks;
  disks.add(2.0, Vector<2>::Zero());
  const auto disk = rigid_balls(disks, 3.0);
  CHECK_THAT(disk.mass[0], WithinRel(3 * std::numbers::pi, 1e-15));
  CHECK_THAT(disk.inertia[0], WithinRel(0.5 * disk.mass[0], 1e-15));  // 1/2 m R^2
}

TEST_CASE("Kinetic energy and angular momentum of two balls turning as one rigid body") {
  Balls<3> balls;
  balls.add(1.0, {1, 0, 0});
  balls.add(1.0, {-1, 0, 0});
  auto bodies = rigid_balls(balls, 1.0);
  const Vector<3> spin(0, 0, 2);
  for (Index i = 0; i < 2; ++i) {
    bodies.spin[i] = spin;
    bodies.velocity[i] = spin.cross(balls.position[i]);
  }
  const double inertia = 2 * (bodies.inertia[0] + bodies.mass[0]);  // Steiner
  CHECK_THAT(bodies.kinetic_energy(), WithinRel(0.5 * inertia * 4, 1e-14));
  CHECK_THAT(bodies.angular_momentum()[2], WithinRel(inertia * 2, 1e-14));
  CHECK(bodies.momentum().isZero(1e-15));
}

TEMPLATE_TEST_CASE_SIG("The generalised force of a stress is its virtual work", "", ((int Dim), Dim), 2, 3) {
  RigidWalls<Dim> walls{container(centred_cube<Dim>(3.0))};
  walls.room.scale = 0.8;
  drive_by_stress(walls, 7.0, 5.0);
  auto wider = walls.room, narrower = walls.room;
  wider.scale += 1e-5;
  narrower.scale -= 1e-5;
  CHECK_THAT(-walls.force, WithinRel(7.0 * (wider.volume() - narrower.volume()) / 2e-5, 1e-9));
  CHECK_THAT(1 / walls.inverse_mass, WithinRel(5.0 * 1.5 * 1.5, 1e-15));
}

TEST_CASE("A density that is not positive is refused") {
  Balls<2> balls;
  balls.add(1.0, Vector<2>::Zero());
  CHECK_THROWS_WITH(rigid_balls(balls, 0.0), jampack_tests::contains("density"));
  CHECK_THROWS_WITH(rigid_balls(balls, std::nan("")), jampack_tests::contains("density"));
}
