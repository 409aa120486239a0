// SPDX-License-Identifier: MIT
#include <jampack/analysis/ball_network.hpp>
#include <jampack/analysis/granular_stress.hpp>
#include <jampack/solver/gauss_seidel.hpp>
#include <jampack/stepping/hertz_balance.hpp>
#include <jampack/stepping/jam.hpp>
#include <jampack/stepping/moreau_rigid.hpp>
#include <numbers>

#include "../catch.hpp"

using namespace jampack;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

TEST_CASE("One sphere between six planes is the simple cubic lattice: P/E* = (2/3) (1 - L/d)^(3/2) d^2/L^2") {
  const double d = 0.3;
  const HertzCheck law{.young = 7.0, .poisson = 0.3};
  for (const double closed : {0.999, 0.98, 0.9}) {
    const double edge = closed * d;
    Balls<3> balls;
    balls.add(d, {0.003 * d, -0.004 * d, 0.002 * d});  // finds the middle itself
    const auto room = container(centred_cube<3>(edge));
    const auto state = balance(balls, room, law);
    const double pressure = granular_pressure(contact_network(balls, room.volume(), state.forces));
    CHECK_THAT(pressure / law.modulus_of_two_grains(),
               WithinRel(2.0 / 3.0 * std::pow(1 - closed, 1.5) / (closed * closed), 1e-9));
    CHECK_THAT(balls.position[0].norm(), WithinAbs(0.0, 1e-9 * d));
  }
}

TEST_CASE("One disk between six planes at 60 degrees is the hexagonal lattice: P = sqrt(3) f / l") {
  const double d = 2.0;
  const HertzCheck law{.young = 3.0, .poisson = 0.4, .stiffness_2d = 0.8};
  for (const double closed : {0.999, 0.95}) {
    const double spacing = closed * d;  // l, the distance of neighbouring centres
    Balls<2> balls;
    balls.add(d, {0.001, 0.002});
    const auto room = regular_polygon(6, spacing);
    const auto state = balance(balls, room, law);
    REQUIRE(state.forces.size() == 6);
    // A lattice contact approaches by d - l: two walls' worth, each (d - l) / 2 at twice the modulus.
    const double force = 0.8 * law.modulus_of_two_grains() * (d - spacing);
    const double pressure = granular_pressure(contact_network(balls, room.volume(), state.forces));
    CHECK_THAT(pressure, WithinRel(std::sqrt(3.0) * force / spacing, 1e-9));
    const double fraction = balls.volume() / room.volume();
    CHECK_THAT(fraction, WithinRel(std::numbers::pi / (2 * std::sqrt(3.0)) / (closed * closed), 1e-12));
  }
}

TEMPLATE_TEST_CASE_SIG("In a compacted packing the pressure is the work of closing the box", "",
                       ((int Dim), Dim), 2, 3) {
  auto jammed = jam(random_packing<Dim>({.n_grains = 20, .seed = 3}), Signorini{});
  const HertzCheck law{.young = 2.0};
  auto balls = jammed.packing.balls;
  auto room = container(jammed.packing.box);
  double last = 0.0;
  for (int k = 1; k <= 5; ++k) {
    room.scale = 1.0 - 0.002 * k;
    const auto state = balance(balls, room, law);
    const double pressure = granular_pressure(contact_network(balls, room.volume(), state.forces));
    CHECK(pressure > last);
    last = pressure;
    // dE = - P dV along states of balance, by central differences.
    const auto energy_at = [&](double scale) {
      auto shifted = balls;
      auto near_room = room;
      near_room.scale = scale;
      return balance(shifted, near_room, law).energy;
    };
    const double step = 1e-6;
    const double slope = (energy_at(room.scale + step) - energy_at(room.scale - step)) / (2 * step);
    CHECK_THAT(-slope, WithinRel(pressure * Dim * room.volume() / room.scale, 1e-4));
  }
}

TEMPLATE_TEST_CASE_SIG("Moreau stepping under HertzCheck comes to rest in the same state of balance", "",
                       ((int Dim), Dim), 2, 3) {
  const HertzCheck law{.young = 5.0, .poisson = 0.2};
  Balls<Dim> balls;
  balls.add(1.0, Vector<Dim>::Constant(0.01));
  const auto room = container(centred_cube<Dim>(0.95));
  auto bodies = rigid_balls(balls, 1.0);
  RigidWalls<Dim> walls{room};
  MoreauRigid<Dim, HertzCheck> stepping(law);
  const GaussSeidel solver{{1e-14, 100000}};
  for (int k = 0; k < 300; ++k) REQUIRE(stepping.step(bodies, walls, 1.0, solver).accepted);
  const auto state = balance(balls, room, law);
  const double by_balance = granular_pressure(contact_network(balls, room.volume(), state.forces));
  const double by_stepping =
      granular_pressure(contact_network(bodies.balls, room.volume(), stepping.forces()));
  CHECK_THAT(by_stepping, WithinRel(by_balance, 1e-8));
}

TEST_CASE("A balance that is impossible or not reached is told, not returned") {
  Balls<2> balls;
  balls.add(1.0, {0.1, 0.0});
  const auto room = regular_polygon(6, 0.9);
  CHECK_THROWS_WITH(balance(balls, room, HertzCheck{.young = 0.0}), jampack_tests::contains("Young"));
  CHECK_THROWS_WITH(balance(balls, room, HertzCheck{}, {.max_iterations = 0}),
                    jampack_tests::contains("imbalance"));
  Balls<2> nothing;
  CHECK_THROWS_AS(balance(nothing, room, HertzCheck{}), InvalidInput);
}
