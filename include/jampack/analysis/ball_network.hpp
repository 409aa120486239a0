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

/// Largest |sum of forces| / sum of |forces| over the balls not marked in `is_rattler`.
template <int Dim>
double grain_imbalance(const ContactNetwork<Dim>& network, const Array<char>& is_rattler) {
  Array<Vector<Dim>> sum(network.n_grains(), Vector<Dim>::Zero());
  Array<double> sum_of_norms(network.n_grains(), 0.0);
  for (const auto& contact : network.contacts) {
    sum[contact.candidate] += contact.force;
    sum_of_norms[contact.candidate] += contact.force.norm();
    if (contact.at_wall()) continue;
    sum[contact.antagonist] -= contact.force;
    sum_of_norms[contact.antagonist] += contact.force.norm();
  }
  double imbalance = 0.0;
  for (Index i = 0; i < network.n_grains(); ++i)
    if (!is_rattler[i] && sum_of_norms[i] > 0)
      imbalance = std::max(imbalance, sum[i].norm() / sum_of_norms[i]);
  return imbalance;
}

}  // namespace jampack
