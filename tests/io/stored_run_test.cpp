// SPDX-License-Identifier: MIT
// What a run leaves behind: checkpoints, what the audit says of them, and the contact problem of a failed
// step.
#include <jampack/element/linear_simplex.hpp>
#include <jampack/io/checkpoint_compaction.hpp>
#include <jampack/io/failed_step.hpp>
#include <jampack/law/signorini.hpp>
#include <jampack/law/signorini_coulomb.hpp>
#include <jampack/mesh/disk_mesh.hpp>
#include <jampack/solver/default_solver.hpp>
#include <random>

#include "../analysis/audited.hpp"
#include "temporary_folder.hpp"

using namespace jampack;
using namespace jampack_tests;

namespace {

using Packing = SoftPacking<2, MacroSimplex<2>, NeoHookean>;

template <class Law>
Compaction<Packing, Law> two_disks(Law law) {
  Packing packing(disk_mesh(64), NeoHookean{1, 0.4, 1},
                  container(Box<2>{Vector<2>(-0.86, -0.86), Vector<2>(0.86, 0.86)}));
  packing.add(1.0, {-0.34, -0.33}, Eigen::Rotation2Dd(0.3).toRotationMatrix());
  packing.add(0.9, {0.335, 0.345}, Eigen::Rotation2Dd(-0.7).toRotationMatrix());
  return Compaction<Packing, Law>(std::move(packing), law, {}, {});
}

template <class Law>
void expect_same_future(Law law) {
  const TemporaryFolder folder;
  auto straight = two_disks(law);
  while (!(straight.step.contacts.pairs.size() > 0 && straight.pressure() > 0)) straight.advance();
  write_checkpoint(folder / "a.jpk", stored_state(straight));
  auto resumed = restored_compaction<Packing>(std::get<StoredState<2>>(read_checkpoint(folder / "a.jpk")),
                                              law, CompactionOptions{}, SoftStepOptions{});
  for (int i = 0; i < 8; ++i) {
    straight.advance();
    resumed.advance();
  }
  CHECK(straight.pressure() > 0);
  CHECK(resumed.pressure() == straight.pressure());
  write_checkpoint(folder / "straight.jpk", stored_state(straight));
  write_checkpoint(folder / "resumed.jpk", stored_state(resumed));
  // One byte string: every number of the state, bit for bit.
  CHECK((read_file(folder / "straight.jpk") == read_file(folder / "resumed.jpk")));
}

Compaction<Packing, SignoriniCoulomb> pressed_two_disks() {
  auto run = two_disks(SignoriniCoulomb{0.3});
  while (run.pressure() < 1e-3) run.advance();
  return run;
}

/// Four disks of several sizes pressed in a box until they have this packing fraction.
template <class Law>
StoredState<2> four_disks_at(double packing_fraction, double theta, Law law) {
  Packing packing(disk_mesh(64), NeoHookean{1, 0.45, 1}, container(centred_cube<2>(2.12)));
  packing.add(1.0, {-0.52, -0.5});
  packing.add(0.95, {0.5, -0.5});
  packing.add(1.05, {0.48, 0.51});
  packing.add(0.98, {-0.55, 0.53});
  SoftStepOptions step;
  step.theta = theta;
  Compaction<Packing, Law> compaction(std::move(packing), law, {.settled_afresh = 1e-5}, step);
  while (compaction.packing_fraction() < packing_fraction) compaction.advance();
  REQUIRE(compaction.settle());
  return stored_state(compaction);
}

StoredState<2> pressed_disks(double theta = 1) {
  return four_disks_at(0.83, theta, SignoriniCoulomb{0.3});
}

Eigen::VectorXd random_reactions(Index n) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  return Eigen::VectorXd::NullaryExpr(n, [&] { return normal(random); });
}

// Same W r + q for any r, same laws and steps.
template <class Saved, class Problem>
void check_same(const Saved& saved, const Problem& problem) {
  REQUIRE(saved.n_contacts() == problem.n_contacts());
  const Eigen::VectorXd r = random_reactions(problem.free_velocity.size());
  Eigen::VectorXd u, wanted;
  contact_velocity(saved, r, u);
  contact_velocity(problem, r, wanted);
  CHECK((u - wanted).norm() <= 1e-12 * wanted.norm());
  CHECK(saved.step == problem.step);
  for (Index c = 0; c < problem.n_contacts(); ++c) CHECK(saved.law[c].friction == problem.law[c].friction);
}

}  // namespace

TEST_CASE("a run stopped and resumed is the undisturbed run, bit for bit") {
  SECTION("with friction") {
    expect_same_future(SignoriniCoulomb{0.3});
  }
  SECTION("without") {
    expect_same_future(Signorini{});
  }
}

TEST_CASE("a checkpoint keeps all of a state") {
  const TemporaryFolder folder;
  auto compaction = two_disks(SignoriniCoulomb{0.25});
  for (int i = 0; i < 10; ++i) compaction.advance();
  const auto state = stored_state(compaction, {{"seed", "7"}, {"note", "two\nlines"}});
  write_checkpoint(folder / "a.jpk", state);
  const auto read = std::get<StoredState<2>>(read_checkpoint(folder / "a.jpk"));
  CHECK(read.parameters == state.parameters);
  CHECK(read.element == "macro");
  CHECK(read.material == "neo_hookean");
  CHECK(read.poisson == 0.4);
  CHECK(read.friction == 0.25);
  CHECK(read.room.scale == compaction.packing.room.scale);
  CHECK(read.progress.n_steps == compaction.n_steps);
  CHECK(read.progress.last_duration == compaction.last_duration);
  REQUIRE(read.grains.size() == 2);
  CHECK(read.grains[1].position == compaction.packing.grains[1].position);
  CHECK(read.grains[1].velocity_before == compaction.velocity_before[1]);
  CHECK(read.grains[0].rotation == compaction.packing.grains[0].rotation);
  REQUIRE(read.pairs.size() == compaction.step.contacts.pairs.size());
  REQUIRE(read.walls.size() == compaction.step.contacts.walls.size());
  for (Index c = 0; c < read.pairs.size(); ++c)
    CHECK(read.pairs[c].reaction == compaction.step.contacts.pairs.reaction[c]);
  CHECK(std::filesystem::exists(folder / "a.jpk.part") == false);
}

TEST_CASE("a damaged or foreign checkpoint is refused in one line that names it") {
  const TemporaryFolder folder;
  const auto path = folder / "a.jpk";
  write_checkpoint(path, stored_state(two_disks(Signorini{})));
  const std::string whole = read_file(path);
  const auto reads = [&](const std::string& bytes) {
    write_file(path, bytes);
    try {
      read_checkpoint(path);
    } catch (const InvalidInput& error) {
      CHECK_THAT(error.what(), contains("a.jpk"));
      CHECK(std::string(error.what()).find('\n') == std::string::npos);
      return false;
    }
    return true;
  };
  REQUIRE(reads(whole));
  for (const std::size_t size :
       {std::size_t(0), std::size_t(5), std::size_t(20), std::size_t(40), whole.size() / 2, whole.size() - 1})
    CHECK_FALSE(reads(whole.substr(0, size)));
  CHECK_FALSE(reads(whole + "x"));
  for (const std::size_t at : {std::size_t(0), std::size_t(8), std::size_t(17), std::size_t(30),
                               std::size_t(60), whole.size() / 2, whole.size() - 1}) {
    std::string flipped = whole;
    flipped[at] = static_cast<char>(flipped[at] ^ 0x10);
    CHECK_FALSE(reads(flipped));
  }
  CHECK_THROWS_WITH(read_checkpoint(folder / "none.jpk"), contains("none.jpk"));
}

TEST_CASE("a state is not restored as something else") {
  const auto state = stored_state(two_disks(SignoriniCoulomb{0.3}));
  const auto restore = [&](auto law, double theta) {
    SoftStepOptions options;
    options.theta = theta;
    return restored_compaction<Packing>(state, law, CompactionOptions{}, options);
  };
  CHECK_NOTHROW(restore(SignoriniCoulomb{0.3}, 1));
  CHECK_THROWS_WITH(restore(SignoriniCoulomb{0.2}, 1), contains("friction"));
  CHECK_THROWS_WITH(restore(Signorini{}, 1), contains("friction"));
  CHECK_THROWS_WITH(restore(SignoriniCoulomb{0.3}, 0.5), contains("theta"));
  auto other = state;
  other.element = "linear";
  CHECK_THROWS_WITH(
      restored_compaction<Packing>(other, SignoriniCoulomb{0.3}, CompactionOptions{}, SoftStepOptions{}),
      contains("element linear"));
}

TEST_CASE("a contact problem of deformable grains reads back as it was") {
  auto run = pressed_two_disks();
  const double scale = run.packing.room.scale;
  const auto condensed = run.contact_problem(1e-3);
  const auto file = parse_contact_problem(contact_problem_text(condensed.problem, condensed.guess));
  check_same(std::get<StoredContactProblem<2>>(file.problem), condensed.problem);
  CHECK((file.guess == condensed.guess));
  CHECK(condensed.guess.norm() > 0);  // the forces of the last step
  CHECK(run.packing.room.scale == scale);
}

TEST_CASE("a step that fails leaves the contact problem it was given up before, which can be solved") {
  auto run = pressed_two_disks();
  const TemporaryFolder folder;
  const auto path = folder.path / "failed_step.txt";
  CHECK_FALSE(write_failed_step(path, run.step));
  CHECK_FALSE(std::filesystem::exists(path));

  run.step.options.max_iterations = 0;
  REQUIRE_FALSE(run.try_step(0.01));
  REQUIRE(write_failed_step(path, run.step));
  const auto file = read_contact_problem(path);
  const auto& saved = std::get<StoredContactProblem<2>>(file.problem);
  const auto failed = run.step.failed_contact_problem();
  REQUIRE(failed.has_value());
  check_same(saved, failed->problem);

  Eigen::VectorXd r = file.guess;
  CHECK(scaled_residual(saved, r) > 1e-3);  // nothing was solved yet
  const SolveReport report = DefaultSolver{.stop = {.tolerance = 1e-8}}.solve(saved, r);
  CHECK(report.converged);
  CHECK(r.norm() > 0);

  run.step.options.max_iterations = SoftStepOptions{}.max_iterations;
  REQUIRE(run.try_step(1e-3));
  CHECK_FALSE(run.step.failed_contact_problem().has_value());
}

TEST_CASE("the audit passes a pressed packing of disks and sees what is tampered with") {
  static const StoredState<2> good = pressed_disks();
  auto state = good;
  const AuditBounds bounds;
  SECTION("as it is") {
    const AuditReport report = audit_of(state);
    check_all_good(report);
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
  auto state = four_disks_at(0.9, 1, Signorini{});
  REQUIRE(state.n_pair_unknowns == 1);
  const AuditReport report = audit_of(state);
  check_all_good(report);
  strongest(state.pairs).reaction *= 1.1;
  CHECK_FALSE(audit_of(state).is_good());
}
