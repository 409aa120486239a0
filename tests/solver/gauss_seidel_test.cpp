// SPDX-License-Identifier: MIT
#include <jampack/problem/grain_compliance_delassus.hpp>
#include <jampack/solver/gauss_seidel.hpp>

#include "../catch.hpp"
#include "ball_packing.hpp"

using namespace jampack;
using jampack_tests::pressed_packing;

namespace {

template <class Problem>
Eigen::VectorXd after_sweeps(const Problem& problem, GaussSeidel solver, Index n_sweeps) {
  solver.stop = {.tolerance = 1e-15, .max_sweeps = n_sweeps};
  Eigen::VectorXd r = Eigen::VectorXd::Zero(problem.free_velocity.size());
  solver.solve(problem, r);
  return r;
}

template <SlipAccuracy accuracy, class Problem>
Eigen::VectorXd swept(const Problem& problem, SweepOrder order, double relaxation) {
  Eigen::VectorXd r = Eigen::VectorXd::Zero(problem.free_velocity.size());
  GaussSeidelSweeps<Problem, accuracy> sweeps(problem, r);
  std::uint64_t state = 1;
  for (int k = 0; k < 5; ++k) {
    if (order == SweepOrder::shuffled) sweeps.shuffle(state);
    sweeps.sweep(r, relaxation);
    if (order == SweepOrder::symmetric) sweeps.reverse();
  }
  return r;
}

// W of the same problem as one dense compliance a ball.
template <int N>
GrainComplianceDelassus<N> by_grain(const RigidBallsDelassus<N, N>& balls) {
  Array<GrainCompliance<N>> grains(balls.bodies().size());
  for (Index c = 0; c < balls.n_contacts(); ++c) {
    const auto& contact = balls.contacts()[c];
    grains[contact.candidate].contact.push_back(c);
    if (contact.antagonist >= 0) grains[contact.antagonist].contact.push_back(c);
  }
  for (Index b = 0; b < grains.size(); ++b) {
    GrainCompliance<N>& grain = grains[b];
    const Index width = N * grain.contact.size();
    grain.sign.assign(grain.contact.size(), 1.0);
    // With all other bodies held: W of this body alone.
    Array<InverseInertia> only(balls.bodies().size(), {0, 0});
    only[b] = balls.bodies()[b];
    Array<BallContact<N>> contacts;
    for (const Index c : grain.contact) contacts.push_back(balls.contacts()[c]);
    const RigidBallsDelassus<N, N> alone(only, contacts);
    grain.compliance.resize(width, width);
    Eigen::VectorXd column;
    for (Index j = 0; j < width; ++j) {
      alone.apply(Eigen::VectorXd::Unit(width, j), column);
      grain.compliance.col(j) = column;
    }
  }
  return {balls.n_contacts(), std::move(grains)};
}

// The same packing with walls that stand still, pressed by a velocity towards the centre.
template <int Dim, int N>
auto squeezed(Index n_balls) {
  auto problem = pressed_packing<Dim, N>(n_balls, Dim == 3 ? 0.66 : 0.86, 0.3);
  using Problem = decltype(problem);
  auto contacts = problem.delassus.contacts();
  for (auto& contact : contacts) contact.wall_rate = 0;
  return Problem({problem.delassus.bodies(), std::move(contacts)}, problem.free_velocity, problem.law);
}

template <class Problem>
void check_colouring(const Problem& problem) {
  const Colouring colouring = colour_contacts(problem.delassus);
  const Index n = problem.n_contacts();
  Array<Index> times(n, Index{0});
  for (const Index c : colouring.order) ++times[c];
  CHECK(std::count(times.begin(), times.end(), 1) == n);
  // What a chunk changes, no other chunk of a shared class depends on: judged by W itself.
  const auto blocks = stored_blocks(problem.delassus);
  Array<Index> chunk_of(n), class_of(n);
  for (Index k = 0; k < colouring.classes.size(); ++k)
    for (Index m = colouring.classes[k].first; m < colouring.classes[k].last; ++m)
      for (Index p = colouring.chunks[m].first; p < colouring.chunks[m].last; ++p) {
        chunk_of[colouring.order[p]] = m;
        class_of[colouring.order[p]] = k;
      }
  Index n_clashes = 0;
  for (const auto& block : blocks)
    n_clashes += class_of[block.row] == class_of[block.column] &&
                 colouring.classes[class_of[block.row]].shared &&
                 chunk_of[block.row] != chunk_of[block.column] && !block.value.isZero(0);
  CHECK(n_clashes == 0);
  CHECK(colouring.classes.front().shared);
}

template <class Problem>
void check_threads(const Problem& problem) {
  const GaussSeidel one{.order = SweepOrder::coloured};
  const Eigen::VectorXd r = after_sweeps(problem, one, 8);
  CHECK(r.norm() > 0);
  for (const int n_threads : {2, 3, 5})
    CHECK(r == after_sweeps(problem, GaussSeidel{.order = SweepOrder::coloured, .threads = {n_threads}}, 8));
}

}  // namespace

TEST_CASE("The kernel for spheres sweeps as the stored matrix does") {
  const auto problem = pressed_packing<3, 3>(60, 0.66, 0.3);
  const ContactProblem stored(as_block_sparse(problem.delassus), problem.free_velocity, problem.law);
  for (const double relaxation : {1.0, 0.8})
    for (const SweepOrder order : {SweepOrder::natural, SweepOrder::symmetric, SweepOrder::shuffled}) {
      constexpr SlipAccuracy exact = SlipAccuracy::exact, for_a_sweep = SlipAccuracy::for_a_sweep;
      const Eigen::VectorXd x = swept<for_a_sweep>(problem, order, relaxation);  // exact as it is
      CHECK(x.norm() > 0);
      CHECK((x - swept<exact>(stored, order, relaxation)).norm() <= 1e-12 * x.norm());
      // Sliding directions that turn by an angle below 0.1 are off by about its cube.
      CHECK((x - swept<for_a_sweep>(stored, order, relaxation)).norm() <= 1e-4 * x.norm());
    }
}

TEST_CASE("A class of colours holds nothing that depends on each other") {
  check_colouring(pressed_packing<3, 3>(600, 0.66, 0.3));
  check_colouring(pressed_packing<2, 2>(300, 0.86, 0.3));
  check_colouring(pressed_packing<3, 1>(300, 0.66, 0));
  const auto problem = squeezed<3, 3>(200);
  check_colouring(problem);
  check_colouring(ContactProblem(as_block_sparse(problem.delassus), problem.free_velocity, problem.law));
  check_colouring(ContactProblem(by_grain<3>(problem.delassus), problem.free_velocity, problem.law));
}

TEST_CASE("Any number of threads gives the bits of one") {
  check_threads(pressed_packing<3, 3>(600, 0.66, 0.3));
  check_threads(pressed_packing<2, 2>(300, 0.86, 0.3));
  check_threads(pressed_packing<3, 1>(300, 0.66, 0));
  const auto problem = squeezed<3, 3>(200);
  check_threads(ContactProblem(as_block_sparse(problem.delassus), problem.free_velocity, problem.law));
  check_threads(ContactProblem(by_grain<3>(problem.delassus), problem.free_velocity, problem.law));
}

TEST_CASE("Every order ends at a solution") {
  const auto problem = pressed_packing<3, 3>(200, 0.66, 0.3);
  for (const SweepOrder order :
       {SweepOrder::natural, SweepOrder::symmetric, SweepOrder::shuffled, SweepOrder::coloured}) {
    Eigen::VectorXd r = Eigen::VectorXd::Zero(problem.free_velocity.size());
    CHECK(GaussSeidel{.stop = {.tolerance = 1e-6, .max_sweeps = 20000}, .order = order}
              .solve(problem, r)
              .converged);
    CHECK(scaled_residual(problem, r) <= 1e-6);
  }
}
