// SPDX-License-Identifier: MIT
#include <jampack/detection/ball_gaps.hpp>
#include <jampack/detection/ball_warm_start.hpp>
#include <jampack/detection/brute_force.hpp>
#include <jampack/detection/r_tree.hpp>
#include <jampack/packing/random_packing.hpp>

#include "../catch.hpp"

using namespace jampack;
using Catch::Matchers::WithinAbs;

namespace {

template <int Dim>
bool same(const Array<BallGap<Dim>>& a, const Array<BallGap<Dim>>& b) {
  if (a.size() != b.size()) return false;
  for (Index c = 0; c < a.size(); ++c)
    if (a[c].candidate != b[c].candidate || a[c].antagonist != b[c].antagonist || a[c].wall != b[c].wall ||
        a[c].gap != b[c].gap || a[c].normal != b[c].normal)
      return false;
  return true;
}

}  // namespace

TEMPLATE_TEST_CASE_SIG("The R-tree finds what brute force finds, while balls wander and grow", "",
                       ((int Dim), Dim), 2, 3) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    auto packing = random_packing<Dim>({.n_grains = 60, .polydispersity = 0.6, .seed = seed});
    RandomSource random(seed + 100);
    RTree<Dim> tree(0.2);
    BruteForce<Dim> all;
    const auto room = container(packing.box);
    Array<BallGap<Dim>> found, expected;
    Index n_found = 0;
    for (int k = 0; k < 30; ++k) {
      const double reach = 0.05 + 0.1 * random.unit();
      find_gaps(tree, packing.balls, room, reach, found);
      find_gaps(all, packing.balls, room, reach, expected);
      REQUIRE(same(found, expected));
      n_found += found.size();
      for (auto& x : packing.balls.position)
        for (int axis = 0; axis < Dim; ++axis) x[axis] += random.uniform(-0.02, 0.02);
      for (auto& d : packing.balls.diameter) d *= 1.001;
    }
    CHECK(n_found > 0);
    CHECK(tree.n_rebuilds() > 1);   // the skin was used up
    CHECK(tree.n_rebuilds() < 30);  // and used
  }
}

TEST_CASE("A gap is the distance of the surfaces, its normal points to the candidate") {
  Balls<2> balls;
  balls.add(1.0, {0.0, 0.0});
  balls.add(2.0, {3.0, 4.0});
  BruteForce<2> all;
  Array<BallGap<2>> gaps;
  Container<2> room = container(Box<2>{{-0.7, -10}, {10, 10}});
  find_gaps(all, balls, room, 3.6, gaps);
  REQUIRE(gaps.size() >= 2);
  CHECK(gaps[0].candidate == 1);
  CHECK(gaps[0].antagonist == 0);
  CHECK_THAT(gaps[0].gap, WithinAbs(3.5, 1e-15));
  CHECK_THAT((gaps[0].normal - Vector<2>(0.6, 0.8)).norm(), WithinAbs(0.0, 1e-15));
  CHECK(gaps[1].at_wall());
  CHECK(gaps[1].candidate == 0);
  CHECK(gaps[1].wall == 0);
  CHECK_THAT(gaps[1].gap, WithinAbs(0.2, 1e-15));
  CHECK(gaps[1].normal == Vector<2>::UnitX());
}

TEST_CASE("Coinciding centres are refused, not given a direction") {
  Balls<3> balls;
  balls.add(1.0, {0.0, 0.0, 0.0});
  balls.add(1.0, {0.0, 0.0, 0.0});
  BruteForce<3> all;
  Array<BallGap<3>> gaps;
  CHECK_THROWS_WITH(find_gaps(all, balls, Container<3>{}, 0.1, gaps), jampack_tests::contains("coincide"));
}

TEST_CASE("The warm start finds a pair's force again, whatever the order, and nothing else") {
  Array<BallForce<3>> forces;
  forces.push_back({{.candidate = 4, .antagonist = 2}, {1, 2, 3}});
  forces.push_back({{.candidate = 1, .antagonist = 0}, {4, 5, 6}});
  forces.push_back({{.candidate = 4, .wall = 2}, {7, 8, 9}});
  BallWarmStart<3> warm_start;
  warm_start.remember(forces);
  for (const auto& entry : forces) CHECK(warm_start.force(entry.contact) == entry.force);
  CHECK(warm_start.force({.candidate = 4, .antagonist = 1}).isZero(0.0));
  CHECK(warm_start.force({.candidate = 4, .wall = 1}).isZero(0.0));
  warm_start.forget();
  CHECK(warm_start.force(forces[0].contact).isZero(0.0));
}

TEST_CASE("An R-tree with an impossible skin is refused") {
  CHECK_THROWS_AS(RTree<2>(-0.1), InvalidInput);
  CHECK_THROWS_AS(RTree<3>(std::nan("")), InvalidInput);
}
