// SPDX-License-Identifier: MIT
#include <algorithm>
#include <jampack/element/macro_simplex.hpp>
#include <jampack/law/signorini_coulomb.hpp>
#include <jampack/material/neo_hookean.hpp>
#include <jampack/mesh/disk_mesh.hpp>
#include <jampack/stepping/compaction.hpp>
#include <jampack/stepping/coupled_newton.hpp>
#include <random>

#include "../catch.hpp"

using namespace jampack;

namespace {

using Packing = SoftPacking<2, MacroSimplex<2>, NeoHookean>;
using Law = SignoriniCoulomb;

constexpr double tolerance = 1e-10, duration = 0.5, diameter = 0.9;

/// Two disks that press on each other and on walls at the end of a step, moved off by `offset`.
struct Scene {
  Packing before = disks();
  AugmentedBalance<Packing, Law> balance;
  WatchedContacts<Packing, Law> contacts;
  CondensedStep<Packing, Law> condensed;
  Array<double> history;  ///< distances from the end that were asked for

  static Packing disks() {
    Packing packing(disk_mesh(64), NeoHookean{.young = 1, .poisson = 0.45}, container(centred_cube<2>(1.8)));
    packing.add(1.0, {-0.39, -0.38});
    packing.add(diameter, {0.44, 0.06}, Eigen::Rotation2Dd(0.4).toRotationMatrix());
    return packing;
  }

  explicit Scene(double offset) {
    SoftStep<Packing, Law> step(Law{0.3}, {});
    Packing after = before;
    while (after.room.scale > 0.94) {
      before = after;
      REQUIRE(step.advance(after, duration, after.room.scale * 0.99).converged);
    }
    before.room.scale = after.room.scale;
    contacts = step.contacts;
    balance.law = step.law;
    balance.penalty = 10;
    balance.least_force = 1e-12;
    REQUIRE(balance.begin(before, duration));
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    for (Index g = 0; g < 2; ++g)
      balance.x[g] =
          after.grains[g].position.unaryExpr([&](double x) { return x + offset * normal(random); });
    REQUIRE(balance.linearise(before));
    balance.evaluate(before, contacts);
  }

  double distance() const {
    return std::max({balance.equilibrium_residual(), balance.contact_residual, balance.surface_residual}) /
           tolerance;
  }

  /// Newton's method with the contacts nearer than `near` condensed.
  std::optional<double> run(double near, double longest = 0.1, double round_off = 1e-15) {
    const auto problem = condense(before, contacts, balance, condensed, near);
    CoupledNewton<Packing, Law> newton(condensed, problem, {});
    return newton.run(
        before, longest, round_off,
        [&](const auto&) {
          history.push_back(distance());
          return history.back();
        },
        balance, contacts);
  }

  Index n_loaded() const {
    return std::count_if(contacts.pairs.reaction.begin(), contacts.pairs.reaction.end(),
                         [](const auto& r) { return r.norm() > 1e-8; });
  }
};

}  // namespace

TEST_CASE("Newton's method on balance and law ends a step in few steps") {
  Scene scene(1e-5);
  REQUIRE(scene.n_loaded() >= 2);
  REQUIRE(scene.distance() > 1e6);
  REQUIRE(scene.run(1e-4));
  CHECK(scene.distance() <= 1);
  REQUIRE(scene.history.size() >= 3);
  CHECK(scene.history.size() <= 9);
  // Each linear system is solved to a fiftieth: the last step gains at least that.
  const double* last = scene.history.data() + scene.history.size() - 1;
  CHECK(last[0] <= 0.05 * last[-1]);
}

TEST_CASE("contacts that the condensed problem does not know are found all the same") {
  Scene scene(1e-5);
  auto all = scene.contacts;
  // Condensed without forces and with no gap wide enough, it knows those only that have closed.
  for (auto& r : scene.contacts.pairs.reaction) r.setZero();
  for (auto& r : scene.contacts.walls.reaction) r.setZero();
  const auto problem = condense(scene.before, scene.contacts, scene.balance, scene.condensed, 0.0);
  scene.contacts = all;
  REQUIRE(problem.pairs.size() < scene.n_loaded());
  CoupledNewton<Packing, Law> newton(scene.condensed, problem, {});
  REQUIRE(newton.run(
      scene.before, 0.1, 1e-15, [&](const auto&) { return scene.distance(); }, scene.balance,
      scene.contacts));
  CHECK(scene.distance() <= 1);
}

TEST_CASE("from far away Newton's method comes to the same end") {
  Scene near(1e-6), far(1e-4);
  REQUIRE(near.run(1e-4));
  REQUIRE(far.run(1e-3));
  CHECK(far.distance() <= 1);
  for (Index g = 0; g < near.balance.x.size(); ++g)
    CHECK((near.balance.x[g] - far.balance.x[g]).cwiseAbs().maxCoeff() < 1e-8);
}

namespace {

/// Whether all is as in `other`.
void check_same(const Scene& scene, const Scene& other) {
  for (Index g = 0; g < other.balance.x.size(); ++g) CHECK((scene.balance.x[g] == other.balance.x[g]));
  CHECK(scene.distance() == Approx(other.distance()));
}

}  // namespace

TEST_CASE("a point of higher potential is not accepted") {
  Scene scene(1e-5);
  const Scene before = scene;
  CHECK_FALSE(scene.run(1e-4, 0.1, -1e3));  // no point has a potential lower by so much
  CHECK(*std::min_element(scene.history.begin(), scene.history.end()) <= 1);
  check_same(scene, before);
}

TEST_CASE("where no step is allowed Newton's method leaves all as it was") {
  Scene scene(1e-5);
  const Scene before = scene;
  CHECK_FALSE(scene.run(1e-4, 0));
  check_same(scene, before);
}
