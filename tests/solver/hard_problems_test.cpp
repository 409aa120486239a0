// SPDX-License-Identifier: MIT
#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <jampack/law/signorini.hpp>
#include <jampack/problem/rigid_balls_delassus.hpp>
#include <jampack/solver/admm.hpp>
#include <jampack/solver/default_solver.hpp>
#include <new>

#include "../catch.hpp"

using namespace jampack;
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
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace {

// n balls of the given masses in a row between a wall at the left and a push of the given impulse at the
// right.
template <int N>
auto chain(Index n, double impulse, double mass_of_last = 1) {
  Array<InverseInertia> bodies(n, {1, 2.5});
  bodies[n - 1] = {1 / mass_of_last, 2.5 / mass_of_last};
  Array<BallContact<3>> contacts;
  for (Index k = 0; k < n; ++k)  // n from left to right: ball k rests on ball k - 1 or the wall
    contacts.push_back({k, k - 1, contact_frame<3>(Vector<3>(1, 0, 0)), 0.5, 0.5});
  Eigen::VectorXd q = Eigen::VectorXd::Zero(N * n);
  q[N * (n - 1)] = -impulse / mass_of_last;
  RigidBallsDelassus<3, N> delassus(bodies, contacts);
  if constexpr (N == 1)
    return ContactProblem<RigidBallsDelassus<3, N>, Signorini>(delassus, q, Array<Signorini>(n));
  else
    return ContactProblem(delassus, q, Array<SignoriniCoulomb>(n, {0.3}));
}

// Rigid block (unit mass, moments of inertia 1/6) on n^2 points of a floor, falling at speed 1 and sliding at
// `slide`; every contact `copies` times.
ContactProblem<BlockSparseDelassus<3>> block_on_floor(int n, double slide, double friction, int copies = 1,
                                                      double mass = 1, double length = 1, double time = 1) {
  const double unit_speed = length / time;
  Array<Eigen::Matrix<double, 3, 6>> h;
  for (int k = 0; k < n * n * copies; ++k) {
    const int point = k % (n * n);
    const Vector<3> arm =
        length * Vector<3>(-0.5 + point % n / (n - 1.0), -0.5 + point / n / (n - 1.0), -0.5);
    Eigen::Matrix<double, 3, 6> row;  // N = z, T1 = x, T2 = y
    const Matrix<3> axes = (Matrix<3>() << 0, 0, 1, 1, 0, 0, 0, 1, 0).finished();
    row.leftCols<3>() = axes;
    for (int j = 0; j < 3; ++j) row.col(3 + j) = axes * Vector<3>::Unit(j).cross(arm);
    h.push_back(row);
  }
  Eigen::Matrix<double, 6, 1> inverse_mass, v;
  inverse_mass << 1 / mass, 1 / mass, 1 / mass, Vector<3>::Constant(6 / (mass * length * length));
  v << slide * unit_speed, 0, -unit_speed, 0, 0, 0;
  Array<DelassusBlock<3>> blocks;
  Eigen::VectorXd q(3 * h.size());
  for (Index c = 0; c < h.size(); ++c) {
    q.segment<3>(3 * c) = h[c] * v;
    for (Index d = 0; d < h.size(); ++d)
      blocks.push_back({c, d, h[c] * inverse_mass.asDiagonal() * h[d].transpose()});
  }
  return {BlockSparseDelassus<3>(h.size(), blocks), q, Array<SignoriniCoulomb>(h.size(), {friction})};
}

template <class Problem>
SolveReport solve(const Problem& problem, Eigen::VectorXd& r, double tolerance = 1e-10) {
  r = Eigen::VectorXd::Zero(problem.free_velocity.size());
  return DefaultSolver{.stop = {.tolerance = tolerance}}.solve(problem, r);
}

Vector<3> total(const Eigen::VectorXd& r) {
  Vector<3> sum = Vector<3>::Zero();
  for (Index c = 0; c < r.size() / 3; ++c) sum += r.segment<3>(3 * c);
  return sum;
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
      const Vector<3> q(-1, 0.6 * friction * factor, 0.8 * friction * factor);
      const ContactProblem problem(BlockSparseDelassus<3>(1, {{0, 0, Matrix<3>::Identity()}}), q,
                                   {{friction}});
      Eigen::VectorXd r, u;
      REQUIRE(solve(problem, r, 1e-12).converged);
      contact_velocity(problem, r, u);
      CHECK_THAT(u.tail<2>().norm(), WithinAbs(std::max(0.0, friction * (factor - 1)), 1e-12));
    }
}

TEST_CASE("A wedge locks itself only if friction exceeds the tangent of its half angle") {
  // A ball without rotation pressed into a symmetric groove: both faces push with r_N along their normals; a
  // pull p out of the groove is held by prestress only as long as the opening angle allows.
  const double angle = 0.3;
  for (const double factor : {0.99, 1.01}) {
    const double friction = std::tan(angle) * factor;
    Array<DelassusBlock<2>> blocks;
    Eigen::Matrix<double, 2, 2> frame[2];
    for (int k = 0; k < 2; ++k) {
      const double sign = k == 0 ? 1 : -1;  // faces at +-angle to the vertical, normals nearly horizontal
      frame[k] = contact_frame<2>(Vector<2>(sign * std::cos(angle), std::sin(angle)));
    }
    for (Index c = 0; c < 2; ++c)
      for (Index d = 0; d < 2; ++d) blocks.push_back({c, d, frame[c] * frame[d].transpose()});
    // Pulled out upwards at speed 1: with a prestress as first guess it may stay (locked) or must leave.
    Eigen::VectorXd q(4), r(4);
    for (int k = 0; k < 2; ++k) q.segment<2>(2 * k) = frame[k] * Vector<2>(0, 1);
    const ContactProblem problem(BlockSparseDelassus<2>(2, blocks), q,
                                 Array<SignoriniCoulomb>(2, {friction}));
    // The locked state: both reactions on the lower edge of their cones, equal, adding up to (0, -1).
    const bool locks = factor > 1;
    const Vector<2> half = Vector<2>(0, -0.5);
    const double push = 1000;
    for (int k = 0; k < 2; ++k) {
      const double sign = k == 0 ? 1 : -1;
      r.segment<2>(2 * k) = frame[k] * (half + Vector<2>(sign * push, 0));
    }
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
  // One ball squeezed by two walls that both move inwards.
  Array<BallContact<2>> contacts = {{0, -1, contact_frame<2>(Vector<2>(1, 0)), 0.5},
                                    {0, -1, contact_frame<2>(Vector<2>(-1, 0)), 0.5}};
  const ContactProblem problem(RigidBallsDelassus<2, 2>({{1, 2}}, contacts), Eigen::Vector4d(-1, 0, -1, 0),
                               Array<SignoriniCoulomb>(2, {0.3}));
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
  CHECK(solve(ContactProblem(BlockSparseDelassus<3>(1, {}), Eigen::Vector3d(1, 2, 3), law), r).converged);
  CHECK_FALSE(DefaultSolver{.stop = {.max_sweeps = 100}}
                  .solve(ContactProblem(BlockSparseDelassus<3>(1, {}), Eigen::Vector3d(-1, 0, 0), law),
                         r = Eigen::Vector3d::Zero())
                  .converged);
  CHECK_THROWS_AS(ContactProblem(BlockSparseDelassus<3>(1, {}), Eigen::Vector3d(std::nan(""), 0, 0), law),
                  InvalidInput);
  CHECK_THROWS_AS(
      ContactProblem(BlockSparseDelassus<3>(1, {}), Eigen::Vector3d(0, 0, 0), Array<SignoriniCoulomb>{{-1}}),
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
