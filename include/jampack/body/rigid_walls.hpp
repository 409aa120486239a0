// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/geometry/container.hpp>

namespace jampack {

/// The plane walls of a container as one rigid body with one degree of freedom, the container's scale. Wall w
/// moves away from the centre at distance[w] * scale_rate.
///
/// Driven by velocity: `inverse_mass` is 0 and `scale_rate` (1 / time) is what the caller sets, 0 for walls
/// at rest. Driven by stress: the rate is an unknown of the contact problem, one more body of mass 1 /
/// `inverse_mass` (mass * length^2) pushed by the generalised `force` (docs/theory/rigid_stage.md, eq. 5).
template <int Dim>
struct RigidWalls {
  Container<Dim> room;
  double scale_rate = 0.0;
  double inverse_mass = 0.0;
  double force = 0.0;  ///< conjugate to the scale (energy); negative closes

  double kinetic_energy() const {
    return inverse_mass > 0 ? 0.5 * scale_rate * scale_rate / inverse_mass : 0.0;
  }
};

/// dV / dscale of a container: a stress sigma on all its walls is the generalised force - sigma dV / dscale.
template <int Dim>
double volume_rate(const Container<Dim>& room) {
  return Dim * room.volume() / room.scale;
}

/// Lets a stress sigma >= 0 (force / length^(Dim - 1), compression) drive the walls. The closing mode gets
/// the inertia of `mass` sitting at the mean distance of the walls.
template <int Dim>
void drive_by_stress(RigidWalls<Dim>& walls, double stress, double mass) {
  double mean_distance = 0.0;
  for (const double distance : walls.room.distance) mean_distance += distance;
  mean_distance /= static_cast<double>(walls.room.n_walls());
  walls.inverse_mass = 1.0 / (mass * mean_distance * mean_distance);
  walls.force = -stress * volume_rate(walls.room);
}

}  // namespace jampack
