// SPDX-License-Identifier: MIT
#include <jampack/stepping/jam.hpp>
#include <numbers>

#include "../catch.hpp"

using namespace jampack;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

TEMPLATE_TEST_CASE_SIG("One ball jams in the cube that touches it on all sides", "", ((int Dim), Dim), 2, 3) {
  const auto jammed = jam(random_packing<Dim>({.n_grains = 1, .seed = 3}), SignoriniCoulomb{0.3});
  const double simple_cubic = std::numbers::pi / (Dim == 2 ? 4 : 6);
  CHECK_THAT(jammed.packing_fraction, WithinRel(simple_cubic, 1e-4));
  CHECK(jammed.coordination.held.n_wall_contacts == 2 * Dim);
  CHECK_THAT(granular_pressure(jammed.network), WithinRel(1.0, 1e-3));
}

TEMPLATE_TEST_CASE_SIG("Without friction jamming is isostatic: N_gg + N_w = D N_nr + 1 driven wall mode", "",
                       ((int Dim), Dim), 2, 3) {
  const auto seed = static_cast<std::uint64_t>(GENERATE(range(1, 6)));
  CAPTURE(seed);
  // Every force counts here, so they must be solved for better than the smallest of them.
  const auto jammed = jam(random_packing<Dim>({.n_grains = 12, .seed = seed}), Signorini{},
                          {.stress = 2.0,
                           .fraction_change = 1e-7,
                           .kinetic_energy = 1e-14,
                           .grain_imbalance = 1e-5,
                           .tolerance = 1e-9});
  const auto& held = jammed.coordination.held;
  REQUIRE(held.n_grains > 0);
  CHECK(held.n_grain_contacts + held.n_wall_contacts == Dim * held.n_grains + 1);
}

TEMPLATE_TEST_CASE_SIG("With friction jamming needs fewer contacts, at a lower packing fraction", "",
                       ((int Dim), Dim), 2, 3) {
  // phi and contacts a grain that is held, summed over seeds: a single small packing may be an exception.
  double rough_fraction = 0.0, smooth_fraction = 0.0, rough_contacts = 0.0, smooth_contacts = 0.0;
  const auto contacts_a_grain = [](const JammedPacking<Dim>& jammed) {
    const auto& held = jammed.coordination.held;
    return static_cast<double>(held.n_grain_contacts + held.n_wall_contacts) /
           static_cast<double>(held.n_grains);
  };
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const auto loose = random_packing<Dim>({.n_grains = 30, .seed = seed});
    const auto rough = jam(loose, SignoriniCoulomb{0.6});
    const auto smooth = jam(loose, Signorini{});
    rough_fraction += rough.packing_fraction;
    smooth_fraction += smooth.packing_fraction;
    rough_contacts += contacts_a_grain(rough);
    smooth_contacts += contacts_a_grain(smooth);
  }
  CHECK(rough_fraction < smooth_fraction);
  CHECK(rough_contacts < smooth_contacts);
}

TEMPLATE_TEST_CASE_SIG("A jammed packing is at rest, in balance, under the stress, and does not overlap", "",
                       ((int Dim), Dim), 2, 3) {
  const double friction = GENERATE(0.0, 0.3, 1.0);
  const double stress = 5.0;
  CAPTURE(friction);
  const auto jammed =
      jam(random_packing<Dim>({.n_grains = 15, .seed = 7}), SignoriniCoulomb{friction}, {.stress = stress});
  CHECK(jammed.report.kinetic_energy <= 1e-6);
  CHECK(jammed.report.grain_imbalance <= 1e-2);
  CHECK(jammed.report.scaled_residual <= 1e-5);
  CHECK_THAT(granular_pressure(jammed.network), WithinRel(stress, 1e-2));
  CHECK_THAT(jammed.packing_fraction, WithinRel(jammed.packing.packing_fraction(), 1e-12));

  // Nothing lies in anything else, by brute force.
  const auto& balls = jammed.packing.balls;
  double deepest = 0.0;
  for (Index i = 0; i < balls.size(); ++i) {
    for (Index j = 0; j < i; ++j)
      deepest = std::max(deepest, 0.5 * (balls.diameter[i] + balls.diameter[j]) -
                                      (balls.position[i] - balls.position[j]).norm());
    for (Index w = 0; w < Box<Dim>::n_walls; ++w)
      deepest =
          std::max(deepest, 0.5 * balls.diameter[i] - jammed.packing.box.wall(w).distance(balls.position[i]));
  }
  CHECK(deepest < 1e-4);

  // Coulomb's cone, walls without friction. The natural map bounds the distance of a force to its cone.
  double all_forces = 0.0;
  for (const auto& contact : jammed.network.contacts) all_forces += contact.force.squaredNorm();
  const double slack = 2 * jammed.report.scaled_residual * std::sqrt(all_forces);
  for (const auto& contact : jammed.network.contacts) {
    Vector<Dim> normal = contact.branch.normalized();
    const double pressing = contact.force.dot(normal);
    const double along = (contact.force - pressing * normal).norm();
    const double mu = contact.at_wall() ? 0.0 : friction;
    CHECK(along <= mu * pressing + slack);
  }
}

TEST_CASE("A hundred spheres with friction 0.3 jam where such packings do") {
  const auto jammed = jam(random_packing<3>({.n_grains = 100, .seed = 1}), SignoriniCoulomb{0.3});
  CHECK(jammed.packing_fraction > 0.50);
  CHECK(jammed.packing_fraction < 0.56);
  // Between the frictional and the frictionless bulk bounds, D + 1 and 2 D.
  CHECK(jammed.coordination.held.coordination_with_walls() > 4.0);
  CHECK(jammed.coordination.held.coordination_with_walls() < 6.0);
}

TEMPLATE_TEST_CASE_SIG("A change of units scales the jammed packing, bit by bit", "", ((int Dim), Dim), 2,
                       3) {
  // Powers of four keep all roundings: any absolute length, mass or time in the code would show.
  const double length = 0x1p-20, density = 0x1p+12, stress = 0x1p+24;
  const RandomPackingOptions grains{.n_grains = 15, .seed = 4};
  RandomPackingOptions scaled_grains = grains;
  scaled_grains.mean_diameter = length;
  const auto one = jam(random_packing<Dim>(grains), SignoriniCoulomb{0.3});
  const auto other =
      jam(random_packing<Dim>(scaled_grains), SignoriniCoulomb{0.3}, {.stress = stress, .density = density});
  CHECK(one.packing_fraction == other.packing_fraction);
  CHECK(one.report.steps == other.report.steps);
  CHECK(one.report.sweeps == other.report.sweeps);
  for (Index i = 0; i < one.packing.balls.size(); ++i)
    CHECK(Vector<Dim>(length * one.packing.balls.position[i]) == other.packing.balls.position[i]);
}

TEST_CASE("The same seed jams into the same packing, another seed into another") {
  const auto once = jam(random_packing<3>({.n_grains = 20, .seed = 5}), SignoriniCoulomb{0.3});
  const auto again = jam(random_packing<3>({.n_grains = 20, .seed = 5}), SignoriniCoulomb{0.3});
  const auto other = jam(random_packing<3>({.n_grains = 20, .seed = 6}), SignoriniCoulomb{0.3});
  CHECK(once.packing.balls.position == again.packing.balls.position);
  CHECK(once.packing_fraction == again.packing_fraction);
  CHECK(once.packing_fraction != other.packing_fraction);
}

TEST_CASE("Impossible jamming is refused with a line that says why") {
  const auto loose = random_packing<2>({.n_grains = 3});
  using jampack_tests::contains;
  CHECK_THROWS_WITH(jam(loose, SignoriniCoulomb{0.3}, {.stress = -1.0}), contains("stress must be positive"));
  CHECK_THROWS_WITH(jam(loose, SignoriniCoulomb{0.3}, {.density = 0.0}),
                    contains("density must be positive"));
  CHECK_THROWS_WITH(jam(loose, SignoriniCoulomb{std::nan("")}), contains("friction"));
  CHECK_THROWS_AS(jam(Packing<2>{}, SignoriniCoulomb{0.3}), InvalidInput);
  CHECK_THROWS_WITH(jam(Packing<2>{}, SignoriniCoulomb{0.3}), contains("zero"));
}

TEST_CASE("Jamming that does not come to rest in the time given says what is missing") {
  const auto loose = random_packing<2>({.n_grains = 10});
  CHECK_THROWS_AS(jam(loose, SignoriniCoulomb{0.3}, {.max_time = 0.5}), NotConverged);
  CHECK_THROWS_WITH(jam(loose, SignoriniCoulomb{0.3}, {.max_time = 0.5}),
                    jampack_tests::contains("kinetic energy") && jampack_tests::contains("try"));
}
