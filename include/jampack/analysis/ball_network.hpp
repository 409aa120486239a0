// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <jampack/analysis/contact_network.hpp>
#include <jampack/detection/ball_warm_start.hpp>
#include <jampack/geometry/ball.hpp>

namespace jampack {

/// The contact network of balls: the contacts of `forces` that carry any, with the normals and gaps under
/// which the forces were found. `volume` is that of the room.
template <int Dim>
ContactNetwork<Dim> contact_network(const Balls<Dim>& balls, double volume,
                                    const Array<BallForce<Dim>>& forces) {
  ContactNetwork<Dim> network;
  network.diameters = balls.diameter;
  network.volume = volume;
  for (const auto& [gap, force] : forces) {
    if (force.isZero(0.0)) continue;
    ContactForce<Dim> contact{gap.candidate, gap.antagonist, gap.wall, force};
    double length = 0.5 * balls.diameter[gap.candidate] + gap.gap;
    if (!gap.at_wall()) length += 0.5 * balls.diameter[gap.antagonist];
    contact.branch = length * gap.normal;
    network.contacts.push_back(contact);
  }
  return network;
}

}  // namespace jampack
