// SPDX-License-Identifier: MIT
#include "hard_problems.hpp"

#include <cmath>
#include <cstdlib>
#include <jampack/solver/admm.hpp>
#include <jampack/solver/default_solver.hpp>
#include <new>

#include "../catch.hpp"

using namespace jampack;
using namespace jampack_tests;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {
Index n_allocations = 0;
}

[[gnu::noinline]] void* operator new(std::size_t size) {
  ++n_allocations;
  if (void* const memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
// Arrays of vectors of the compiler come this way.
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
  ++n_allocations;
  const auto step = static_cast<std::size_t>(alignment);
  if (void* const memory = std::aligned_alloc(step, (size + step - 1) / step * step)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace {

template <class Problem>
SolveReport solve(const Problem& problem, Eigen::VectorXd& r, double tolerance = 1e-10) {
  r = Eigen::VectorXd::Zero(problem.free_velocity.size());
  return DefaultSolver{.stop = {.tolerance = tolerance}}.solve(problem, r);
}

}  // namespace

TEST_CASE("A chain of balls under a push carries the same force everywhere") {
  for (const Index n : {10, 100, 1000}) {
    Eigen::VectorXd r;
    const auto frictionless = chain<1>(n, 2.0);
    CHECK(solve(frictionless, r).converged);
    CHECK((r - Eigen::VectorXd::Constant(n, 2.0)).norm() <= 1e-5 * r.norm());
    CHECK(solve(chain<3>(n, 2.0), r).converged);
    CHECK_THAT(r[0], WithinRel(2.0, 1e-5));
  }
}

TEST_CASE("A ball a million times heavier at the end of the chain") {
  Eigen::VectorXd r;
  CHECK(solve(chain<1>(20, 2e6, 1e6), r, 1e-13).converged);
  CHECK_THAT(r[0], WithinRel(2e6, 1e-5));
}

TEST_CASE("A block on redundant points lands, sticks below the threshold of friction and slides above") {
  for (const int n : {2, 4, 10}) {
    // The fall asks for an impulse of 1, stopping the slide for `slide`; friction gives up to 0.5.
    Eigen::VectorXd r;
    CHECK(solve(block_on_floor(n, 0.2, 0.5), r).converged);
    CHECK_THAT(total(r)[0], WithinRel(1.0, 1e-7));
    CHECK_THAT(total(r)[1], WithinRel(-0.2, 1e-7));
  }
}

TEST_CASE("Ten times the same contacts make the same motion") {
  Eigen::VectorXd once, tenfold;
  CHECK(solve(block_on_floor(2, 0.2, 0.5), once).converged);
  CHECK(solve(block_on_floor(2, 0.2, 0.5, 10), tenfold).converged);
  CHECK((total(once) - total(tenfold)).norm() <= 1e-7);
}

TEST_CASE("Friction at its threshold: a point mass sticks just below and slides just above") {
  for (const double friction : {0.0, 0.01, 0.3, 1.0, 10.0})
    for (const double factor : {1 - 1e-6, 1 + 1e-6}) {
      const auto problem = point_on_floor(friction * factor, friction);
      Eigen::VectorXd r, u;
      REQUIRE(solve(problem, r, 1e-12).converged);
      contact_velocity(problem, r, u);
      CHECK_THAT(u.tail<2>().norm(), WithinAbs(std::max(0.0, friction * (factor - 1)), 1e-12));
    }
}

TEST_CASE("A wedge locks itself only if friction exceeds the tangent of its half angle") {
  const double angle = 0.3;
  for (const double factor : {0.99, 1.01}) {
    Eigen::VectorXd r;
    const auto problem = wedge(angle, std::tan(angle) * factor, r);
    const bool locks = factor > 1;
    CHECK((scaled_residual(problem, r) < 1e-12) == locks);
    CHECK(DefaultSolver{.stop = {.tolerance = 1e-10}}.solve(problem, r).converged);
    Eigen::VectorXd u;
    contact_velocity(problem, r, u);
    CHECK((u.norm() < 1e-8) == locks);
  }
}

TEST_CASE("Units change neither the answer nor the number of sweeps") {
  Eigen::VectorXd reference, r;
  const SolveReport wanted = solve(block_on_floor(3, 0.7, 0.5), reference);
  REQUIRE(wanted.converged);
  for (const double mass : {1e-9, 1.0, 1e9})
    for (const double length : {1e-9, 1e9})
      for (const double time : {1e-9, 1.0, 1e9}) {
        const SolveReport report = solve(block_on_floor(3, 0.7, 0.5, 1, mass, length, time), r);
        CHECK(report.converged);
        CHECK(report.sweeps == wanted.sweeps);
        CHECK((total(r) * time / (mass * length) - total(reference)).norm() <=
              1e-8 * total(reference).norm());
      }
}

TEST_CASE("An infeasible problem is said to be so, in finite numbers") {
  const auto problem = squeezed_ball();
  Eigen::VectorXd r = Eigen::VectorXd::Zero(4);
  const SolveReport report = DefaultSolver{.stop = {.max_sweeps = 2000}}.solve(problem, r);
  CHECK_FALSE(report.converged);
  CHECK(r.allFinite());
  CHECK(std::isfinite(report.residual));
}

TEST_CASE("Nothing, a zero block and NaN") {
  Eigen::VectorXd r;
  CHECK(solve(ContactProblem(BlockSparseDelassus<3>(0, {}), Eigen::VectorXd(), {}), r).converged);
  const Array<SignoriniCoulomb> law = {{0.5}};
  CHECK(solve(ContactProblem(BlockSparseDelassus<3>(1, {}), vector_of({1, 2, 3}), law), r).converged);
  CHECK_FALSE(DefaultSolver{.stop = {.max_sweeps = 100}}
                  .solve(ContactProblem(BlockSparseDelassus<3>(1, {}), vector_of({-1, 0, 0}), law),
                         r = Eigen::Vector3d::Zero())
                  .converged);
  CHECK_THROWS_AS(ContactProblem(BlockSparseDelassus<3>(1, {}), vector_of({std::nan(""), 0, 0}), law),
                  InvalidInput);
  CHECK_THROWS_AS(
      ContactProblem(BlockSparseDelassus<3>(1, {}), vector_of({0, 0, 0}), Array<SignoriniCoulomb>{{-1}}),
      InvalidInput);
}

TEST_CASE("Every solver finds the same motion of the sliding block") {
  const auto problem = block_on_floor(4, 0.7, 0.5);
  const auto check = [&](const auto& solver) {
    Eigen::VectorXd r = Eigen::VectorXd::Zero(problem.free_velocity.size());
    const SolveReport report = solver.solve(problem, r);
    CHECK(report.converged);
    CHECK_THAT(report.residual, WithinRel(scaled_residual(problem, r), 1e-6));
    CHECK_THAT(total(r)[0], WithinRel(1.0, 1e-5));
    CHECK_THAT(total(r)[1], WithinRel(-0.5, 1e-5));
  };
  check(GaussSeidel{});
  check(GaussSeidel{.order = SweepOrder::symmetric});
  check(GaussSeidel{.order = SweepOrder::shuffled});
  check(GaussSeidel{.relaxation = 0.8});
  check(ProximalNewton{});
  check(Admm{});
  check(DefaultSolver{});
}

TEST_CASE("A sweep allocates nothing") {
  const auto check = [](const auto& problem) {
    Eigen::VectorXd r = Eigen::VectorXd::Zero(problem.free_velocity.size());
    GaussSeidelSweeps sweeps(problem, r);
    for (const bool coloured : {false, true}) {
      if (coloured) sweeps.colour(problem, {});
      const Index before = n_allocations;
      for (int k = 0; k < 10; ++k) sweeps.sweep(r);
      CHECK(n_allocations == before);
      CHECK(r.norm() > 0);
    }
  };
  check(block_on_floor(4, 0.7, 0.5));
  check(chain<1>(30, 1.0));
  check(chain<3>(30, 1.0));
}
