// SPDX-License-Identifier: MIT
#include <jampack/law/signorini.hpp>
#include <jampack/problem/grain_compliance_delassus.hpp>
#include <jampack/solver/proximal_newton.hpp>

#include "../catch.hpp"

using namespace jampack;

namespace {

using Problem = ContactProblem<GrainComplianceDelassus<1>, Signorini>;

// A light grain held by three walls on one side: its translation moves all contacts 10^6 times as far as
// their own indentation. The reactions are (1, 2, 3).
const Eigen::Vector3d indentation(1, 2, 4);
const Eigen::Vector3d reaction(1, 2, 3);

Problem light_grain() {
  Eigen::Matrix3d c = Eigen::Matrix3d::Constant(1e6);
  c.diagonal() += indentation;
  Array<GrainCompliance<1>> grains{{.contact = {0, 1, 2}, .sign = {1, 1, 1}, .compliance = c}};
  return {GrainComplianceDelassus<1>(3, std::move(grains)), -c * reaction, Array<Signorini>(3)};
}

// Balanced, but shared out otherwise.
Eigen::VectorXd other_share() {
  return reaction + Eigen::Vector3d(0.3, -0.3, 0);
}

}  // namespace

TEST_CASE("With steps N / tr W_cc the residual does not see how light grains share a load") {
  const Problem problem = light_grain();
  Eigen::VectorXd r = other_share();
  const auto report = ProximalNewton{.stop = {.tolerance = 1e-6}}.solve(problem, r);
  CHECK(report.converged);
  CHECK((r - reaction).norm() > 0.1);
}

TEST_CASE("With a problem's own steps it does, and proximal Newton finds the share") {
  Problem problem = light_grain();
  for (const double softness : indentation) problem.step.push_back(1 / softness);
  Eigen::VectorXd r = other_share();
  CHECK(natural_map_steps(problem) == problem.step);
  CHECK(scaled_residual(problem, r) > 0.05);
  const auto report = ProximalNewton{.stop = {.tolerance = 1e-6}, .regularisation = 1}.solve(problem, r);
  CHECK(report.converged);
  CHECK(report.residual <= 1e-6);
  CHECK((r - reaction).norm() < 1e-4);
}

TEST_CASE("Own steps that do not fit the contacts are refused") {
  Problem problem = light_grain();
  problem.step = {1.0};
  Eigen::VectorXd r = other_share();
  CHECK_THROWS_AS(ProximalNewton{}.solve(problem, r), InvalidInput);
}
