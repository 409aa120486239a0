// SPDX-License-Identifier: MIT
#include <cmath>
#include <jampack/mesh/sphere_points.hpp>
#include <set>

#include "../catch.hpp"

using namespace jampack;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

double coulomb_energy(const Array<Vector<3>>& points) {
  double energy = 0;
  for (Index i = 0; i < points.size(); ++i)
    for (Index j = 0; j < i; ++j) energy += 1 / (points[i] - points[j]).norm();
  return energy;
}

}  // namespace

TEST_CASE("sphere points come close to the known minima of Thomson's problem") {
  // Wales and Ulker, Phys. Rev. B 74, 212101 (2006); the first is the regular tetrahedron, 6 / sqrt(8/3).
  CHECK_THAT(coulomb_energy(sphere_points(4)), WithinRel(6 / std::sqrt(8.0 / 3), 1e-6));
  CHECK_THAT(coulomb_energy(sphere_points(12)), WithinRel(49.165253058, 1e-6));
  CHECK_THAT(coulomb_energy(sphere_points(32)), WithinRel(412.261274651, 1e-3));
  CHECK_THAT(coulomb_energy(sphere_points(53)), WithinRel(1191.922290416, 1e-3));
}

TEST_CASE("the triangulation of sphere points is their convex hull, for every number the meshes use") {
  for (Index n = 4; n <= 154; ++n) {
    const auto points = sphere_points(n);
    const auto hull = sphere_triangulation(points);
    REQUIRE(hull.size() == 2 * n - 4);
    std::set<std::pair<Index, Index>> edges;
    double highest = -1, solid_angle = 0;
    for (const auto& t : hull) {
      const Vector<3>&a = points[t[0]], &b = points[t[1]], &c = points[t[2]];
      const Vector<3> normal = (b - a).cross(c - a).normalized();
      for (const auto& point : points) highest = std::max(highest, normal.dot(point - a));
      for (std::size_t e = 0; e < 3; ++e) edges.emplace(t[e], t[(e + 1) % 3]);
      // Van Oosterom and Strackee's solid angle of a triangle seen from the centre.
      solid_angle += 2 * std::atan2(a.dot(b.cross(c)), 1 + a.dot(b) + b.dot(c) + c.dot(a));
    }
    INFO("n = " << n);
    CHECK(highest < 1e-9);
    CHECK(static_cast<Index>(edges.size()) == 3 * hull.size());  // every directed edge once: a closed surface
    CHECK_THAT(solid_angle, WithinAbs(4 * std::numbers::pi, 1e-9));
  }
}

TEST_CASE("too few or coincident points are refused") {
  CHECK_THROWS_AS(sphere_points(3), InvalidInput);
  auto points = sphere_points(20);
  points[7] = points[3];
  CHECK_THROWS_AS(sphere_triangulation(points), InvalidInput);
}
