// SPDX-License-Identifier: MIT
#include <jampack/io/checkpoint_compaction.hpp>
#include <jampack/law/signorini_coulomb.hpp>
#include <jampack/mesh/ball_mesh.hpp>
#include <jampack/mesh/disk_mesh.hpp>
#include <jampack/stepping/compaction.hpp>
#include <random>

#include "../analysis/audited.hpp"

using namespace jampack;
using namespace jampack_tests;

namespace {

template <int Dim>
using Rubber = SoftPacking<Dim, MacroSimplex<Dim>, NeoHookean>;

Rubber<2> two_disks() {
  Rubber<2> packing(disk_mesh(64), NeoHookean{.young = 1, .poisson = 0.45}, container(centred_cube<2>(2.0)));
  packing.add(1.0, {-0.45, -0.49});
  packing.add(0.9, {0.42, -0.2}, Eigen::Rotation2Dd(0.4).toRotationMatrix());
  return packing;
}

Compaction<Rubber<3>, SignoriniCoulomb> two_spheres(int threads) {
  Rubber<3> packing(ball_mesh(400), NeoHookean{.young = 1, .poisson = 0.495},
                    container(centred_cube<3>(1.64)));
  packing.add(1.0, {-0.3, -0.28, -0.25});
  packing.add(0.9, {0.32, 0.33, 0.29});
  SoftStepOptions options;
  options.threads.count = threads;
  return {std::move(packing), SignoriniCoulomb{0.3}, {}, options};
}

}  // namespace

TEST_CASE("the residual under the forces P(lambda - rho s) is the gradient of the potential") {
  const double theta = GENERATE(1.0, 0.6);
  auto packing = two_disks();
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (auto& grain : packing.grains)
    grain.velocity = grain.velocity.unaryExpr([&](double) { return 1e-2 * normal(random); });
  packing.grains[1].velocity.row(1).array() += 0.3;
  AugmentedBalance<Rubber<2>, SignoriniCoulomb> balance;
  WatchedContacts<Rubber<2>, SignoriniCoulomb> contacts;
  balance.law = {0.3};
  balance.theta = theta;
  balance.least_force = 1e-9;
  balance.penalty = 3;
  REQUIRE(balance.begin(packing, 0.2));
  contacts.find(packing, balance.x, 0.05, SampleSet::all, Threads{});
  for (auto& force : contacts.pairs.reaction) force = Vector<2>(1e-2 * normal(random), 1e-2 * normal(random));
  auto augmented = contacts;  // the forces lambda - rho s: evaluate() cuts them to their cones
  const auto augment = [&](const auto& contact) -> Vector<2> {
    return -balance.penalty * balance.contact_stiffness(packing, contact) *
           contacts.displacement(packing, contact, balance.x);
  };
  for (Index c = 0; c < contacts.pairs.size(); ++c)
    augmented.pairs.reaction[c] += augment(contacts.pairs.contact[c]);
  for (Index c = 0; c < contacts.walls.size(); ++c)
    augmented.walls.reaction[c][0] +=
        contacts.walls.contact[c].normal.dot(augment(contacts.walls.contact[c]));
  balance.evaluate(packing, augmented);
  int sticks = 0, slides = 0;
  for (Index c = 0; c < contacts.pairs.size(); ++c) {
    const auto& n = contacts.pairs.contact[c].normal;
    const auto& force = balance.pair_force[c];
    if (n.dot(force) > 0) ++((force - n.dot(force) * n).norm() > 0.2999 * n.dot(force) ? slides : sticks);
  }
  REQUIRE(slides > 0);  // or friction would not be tested

  const auto x = balance.x;
  Array<Rubber<2>::Nodal> direction;
  double along = 0;
  for (Index g = 0; g < x.size(); ++g) {
    direction.push_back(x[g].unaryExpr([&](double) { return normal(random); }));
    along += direction[g].cwiseProduct(balance.residual[g]).sum();
  }
  const auto slope = [&] {
    const double step = 1e-7;
    double difference = 0;
    for (const double sign : {1.0, -1.0}) {
      for (Index g = 0; g < x.size(); ++g) balance.x[g] = x[g] + sign * step * direction[g];
      difference += sign * balance.potential(packing, contacts);
    }
    balance.x = x;
    return difference / (2 * step);
  };
  balance.hold_bounds(contacts, balance.pair_force);
  CHECK(std::abs(slope() - along) <= 1e-5 * std::abs(along));
  // Other bounds, another potential.
  balance.hold_bounds(contacts, Array<Vector<2>>(contacts.pairs.size(), Vector<2>::Zero()));
  CHECK(std::abs(slope() - along) > 1e-4 * std::abs(along));
}

TEST_CASE("a step that fails leaves the packing as it was") {
  auto run = two_spheres(1);
  while (run.pressure() == 0) run.advance();
  run.step.options.max_iterations = 0;
  const auto before = run.packing;
  CHECK_FALSE(run.try_step(0.01));
  CHECK(run.packing.room.scale == before.room.scale);
  for (Index g = 0; g < before.grains.size(); ++g) {
    CHECK((run.packing.grains[g].position == before.grains[g].position));
    CHECK((run.packing.grains[g].velocity == before.grains[g].velocity));
  }
}

TEST_CASE("a step that ends near balance is kept where that is asked, and only there") {
  auto run = two_spheres(1);
  while (run.pressure() == 0) run.advance();
  run.step.options.scaled_tolerance = -1;  // no law is held so well
  auto packing = run.packing;
  const double scale = packing.room.scale;
  const auto undone = run.step.advance(packing, 1, 0.999 * scale);
  CHECK_FALSE((undone.converged || undone.kept));
  CHECK(packing.room.scale == scale);
  CHECK((packing.grains[0].position == run.packing.grains[0].position));
  const auto kept = run.step.advance(packing, 1, 0.999 * scale, FirstGuess::rest, Unfinished::kept);
  CHECK_FALSE(kept.converged);
  CHECK(kept.kept);
  CHECK(kept.equilibrium_residual < 1e-2);
  CHECK(packing.room.scale == 0.999 * scale);
  CHECK_FALSE((packing.grains[0].position == run.packing.grains[0].position));
}

TEST_CASE("spheres that are pressed settle, and the number of threads changes no bit") {
  auto one = two_spheres(1);
  auto two = two_spheres(2);
  for (auto* run : {&one, &two}) {
    run->advance_to(0.34, 1e-3);
    CHECK(run->packing_fraction() >= 0.34 - 1e-3);
    CHECK(run->packing_fraction() < 0.341);
    CHECK(run->gain < 1);  // grains are compressible
    REQUIRE(run->settle());
    CHECK(grain_imbalance(run->network()) <= run->options.settled);
    CHECK(run->pressure() > 1e-4);
  }
  CHECK(one.n_iterations == two.n_iterations);
  for (Index g = 0; g < 2; ++g) {
    CHECK((one.packing.grains[g].position == two.packing.grains[g].position));
    CHECK((one.packing.grains[g].velocity == two.packing.grains[g].velocity));
  }
}

TEST_CASE("the audit passes spheres, and sees a contact removed") {
  auto run = two_spheres(1);
  run.options.settled_afresh = 1e-5;
  run.advance_to(0.35, 1e-3);
  REQUIRE(run.settle());
  auto state = stored_state(run);
  const AuditReport report = audit_of(state);
  check_all_good(report);
  CHECK(report.n_contact_points >= 7);
  strongest(state.pairs).reaction.setZero();
  CHECK(audit_of(state).equilibrium_residual > 1e-2);
}
