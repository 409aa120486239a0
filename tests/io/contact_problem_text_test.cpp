// SPDX-License-Identifier: MIT
#include <jampack/element/macro_simplex.hpp>
#include <jampack/io/failed_step.hpp>
#include <jampack/material/neo_hookean.hpp>
#include <jampack/mesh/disk_mesh.hpp>
#include <jampack/solver/default_solver.hpp>
#include <jampack/stepping/compaction.hpp>
#include <random>

#include "../catch.hpp"
#include "temporary_folder.hpp"

using namespace jampack;
using namespace jampack_tests;

namespace {

using Disks = SoftPacking<2, MacroSimplex<2>, NeoHookean>;

Compaction<Disks, SignoriniCoulomb> pressed_disks() {
  Disks packing(disk_mesh(64), NeoHookean{.young = 1, .poisson = 0.45}, container(centred_cube<2>(1.7)));
  packing.add(1.0, {-0.36, -0.35});
  packing.add(0.9, {0.38, 0.36}, Eigen::Rotation2Dd(0.4).toRotationMatrix());
  Compaction<Disks, SignoriniCoulomb> run(std::move(packing), {0.3});
  while (run.pressure() < 1e-3) run.advance();
  return run;
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

TEST_CASE("a contact problem of deformable grains reads back as it was") {
  auto run = pressed_disks();
  const double scale = run.packing.room.scale;
  const auto condensed = run.contact_problem(1e-3);
  const auto file = parse_contact_problem(contact_problem_text(condensed.problem, condensed.guess));
  check_same(std::get<StoredContactProblem<2>>(file.problem), condensed.problem);
  CHECK((file.guess == condensed.guess));
  CHECK(condensed.guess.norm() > 0);  // the forces of the last step
  CHECK(run.packing.room.scale == scale);
}

TEST_CASE("steps of the natural map that are not positive are refused") {
  const std::string start =
      "jampack-contact-problem 1 unknowns 1 contacts 1 friction 0 free_velocity -1 step ";
  const std::string end = " blocks 1 0 0 2 end";
  const auto file = parse_contact_problem(start + "0.25" + end);
  CHECK(std::get<StoredContactProblem<1>>(file.problem).step == Array<double>{0.25});
  for (const char* step : {"0", "-1", "nan", "inf"})
    CHECK_THROWS_AS(parse_contact_problem(start + step + end), InvalidInput);
}

TEST_CASE("a step that fails leaves the contact problem it was given up before, which can be solved") {
  auto run = pressed_disks();
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
