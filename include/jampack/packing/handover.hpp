// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <jampack/body/soft_packing.hpp>
#include <jampack/packing/random_packing.hpp>

namespace jampack {

/// The factor >= 1 by which centres and box must grow for every pair of balls, and every ball and wall, to be
/// at least `clearance` radii apart (of the two radii together for a pair). Brute force over pairs.
template <int Dim>
double opening_for_clearance(const Packing<Dim>& packing, double clearance) {
  const auto& balls = packing.balls;
  double opening = 1;
  for (Index i = 0; i < balls.size(); ++i) {
    const double radius = 0.5 * (1 + clearance) * balls.diameter[i];
    for (Index j = 0; j < i; ++j) {
      const double distance = (balls.position[i] - balls.position[j]).norm();
      require(distance > 0, "handover: two balls lie at the same place");
      opening = std::max(opening, (radius + 0.5 * (1 + clearance) * balls.diameter[j]) / distance);
    }
    for (Index w = 0; w < Box<Dim>::n_walls; ++w) {
      const double distance = packing.box.wall(w).distance(balls.position[i]);
      require(distance > 0, "handover: the centre of a ball lies outside the box");
      opening = std::max(opening, radius / distance);
    }
  }
  return opening;
}

/// The handover from rigid to deformable: every ball becomes a stress-free grain at rest, cut from one unit
/// mesh (of ball_mesh or disk_mesh) at the ball's own diameter and turned as the ball is. Centres and box are
/// opened by as little as leaves `clearance` between all of them, so that no overlap is taken over; pressing
/// the packing to its stress again (stepping/press_to.hpp) closes it.
///
///   auto packing = meshed_grains<MacroSimplex>(jammed.packing, ball_mesh(808), NeoHookean{});
///
/// Throws InvalidInput for unusable balls, box, mesh or material.
template <template <int> class ElementType, int Dim, class MaterialType>
SoftPacking<Dim, ElementType<Dim>, MaterialType> meshed_grains(const Packing<Dim>& packing,
                                                               const Mesh<Dim>& mesh,
                                                               const MaterialType& material,
                                                               double clearance = 2e-3) {
  require_usable(packing.balls);
  require_usable(packing.box);
  material.validate();
  const double opening = opening_for_clearance(packing, clearance);
  const Vector<Dim> centre = packing.box.centre();
  Container<Dim> room = container(packing.box);
  for (double& distance : room.distance) distance *= opening;
  room.reference_volume *= Dim == 2 ? opening * opening : opening * opening * opening;
  SoftPacking<Dim, ElementType<Dim>, MaterialType> soft(mesh, material, std::move(room));
  for (Index i = 0; i < packing.balls.size(); ++i)
    soft.add(packing.balls.diameter[i], centre + opening * (packing.balls.position[i] - centre),
             rotation_matrix<Dim>(packing.balls.orientation[i]));
  return soft;
}

}  // namespace jampack
