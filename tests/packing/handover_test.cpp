// SPDX-License-Identifier: MIT
#include <jampack/body/surface_measure.hpp>
#include <jampack/element/linear_simplex.hpp>
#include <jampack/material/neo_hookean.hpp>
#include <jampack/mesh/ball_mesh.hpp>
#include <jampack/mesh/disk_mesh.hpp>
#include <jampack/packing/handover.hpp>

#include "../catch.hpp"

using namespace jampack;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

/// Two balls that overlap by a tenth of their radii, in a box that a third touches.
template <int Dim>
Packing<Dim> overlapping() {
  Packing<Dim> packing;
  packing.box = {Vector<Dim>::Constant(-1), Vector<Dim>::Constant(3)};
  packing.balls.add(1.0, Vector<Dim>::Constant(0.5));
  packing.balls.add(1.0, Vector<Dim>::Constant(0.5) + 0.9 * Vector<Dim>::Unit(0));
  packing.balls.add(0.5, Vector<Dim>::Constant(2.75));
  packing.balls.orientation[0] = turned<Dim>(no_rotation<Dim>(), Spin<Dim>::Constant(0.3));
  return packing;
}

template <int Dim>
Mesh<Dim> unit_mesh() {
  if constexpr (Dim == 2)
    return disk_mesh(100);
  else
    return ball_mesh(200);
}

}  // namespace

TEMPLATE_TEST_CASE_SIG("Handover opens by what the worst overlap asks for and no more", "[handover]",
                       ((int Dim), Dim), 2, 3) {
  const auto packing = overlapping<Dim>();
  CHECK_THAT(opening_for_clearance(packing, 0.0), WithinRel(1 / 0.9, 1e-14));
  CHECK_THAT(opening_for_clearance(packing, 0.01), WithinRel(1.01 / 0.9, 1e-14));

  auto apart = packing;
  apart.balls.position[1] += Vector<Dim>::Unit(0);
  CHECK(opening_for_clearance(apart, 0.0) == 1);
  CHECK_THAT(opening_for_clearance(apart, 0.02), WithinRel(1.02, 1e-14));  // the ball at the walls
}

TEMPLATE_TEST_CASE_SIG("Handed over grains are the balls: size, orientation, no overlap, at rest",
                       "[handover]", ((int Dim), Dim), 2, 3) {
  const auto packing = overlapping<Dim>();
  const auto mesh = unit_mesh<Dim>();
  const auto soft = meshed_grains<LinearSimplex>(packing, mesh, NeoHookean{}, 0.005);
  const double opening = 1.005 / 0.9;
  REQUIRE(soft.grains.size() == 3);
  CHECK_THAT(soft.room.volume(), WithinRel(packing.box.volume() * std::pow(opening, Dim), 1e-13));
  const Vector<Dim> middle = packing.box.centre();
  for (Index g = 0; g < 3; ++g) {
    const auto& grain = soft.grains[g];
    const Vector<Dim> centre = middle + opening * (packing.balls.position[g] - middle);
    const double radius = 0.5 * packing.balls.diameter[g];
    CHECK(grain.velocity.isZero(0));
    CHECK((grain.centre() - centre).norm() < 1e-3 * radius);
    for (const Index node : mesh.boundary_nodes) {
      const Vector<Dim> x = grain.position.col(node);
      CHECK_THAT((x - centre).norm(), WithinRel(radius, 1e-12));
      const Vector<Dim> turned_node =
          rotation_matrix<Dim>(packing.balls.orientation[g]) * mesh.nodes[node] * packing.balls.diameter[g];
      CHECK((x - centre - turned_node).norm() < 1e-14);
      for (Index w = 0; w < soft.room.n_walls(); ++w) CHECK(soft.room.gap(w, x) > 0.004 * radius);
      for (Index other = 0; other < 3; ++other) {
        if (other == g) continue;
        const Vector<Dim> c = middle + opening * (packing.balls.position[other] - middle);
        CHECK((x - c).norm() > 0.5 * packing.balls.diameter[other]);
      }
    }
  }
}

TEST_CASE("Handover refuses what cannot be handed over", "[handover]") {
  auto packing = overlapping<2>();
  packing.balls.position[1] = packing.balls.position[0];
  CHECK_THROWS_AS(opening_for_clearance(packing, 0.0), InvalidInput);
  packing = overlapping<2>();
  packing.balls.position[2][0] = 4;
  CHECK_THROWS_AS(opening_for_clearance(packing, 0.0), InvalidInput);
  CHECK_THROWS_AS(meshed_grains<LinearSimplex>(overlapping<2>(), disk_mesh(100), NeoHookean{.poisson = 0.5}),
                  InvalidInput);
}
