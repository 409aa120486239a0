// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <jampack/core/array.hpp>
#include <jampack/core/dimension.hpp>
#include <jampack/core/error.hpp>
#include <string>
#include <utility>

namespace jampack {

/// One contact between two grains, or between a grain and a wall. However many points two grains touch in,
/// they have one contact, and its force is the vector sum (see merge_contact_points).
template <int Dim>
struct ContactForce {
  Index candidate = -1;                      ///< grain the force acts on
  Index antagonist = -1;                     ///< the other grain, or -1 at a wall
  Index wall = -1;                           ///< wall, or -1 between grains
  Vector<Dim> force = Vector<Dim>::Zero();   ///< on the candidate
  Vector<Dim> branch = Vector<Dim>::Zero();  ///< to the candidate's centre, from the antagonist's or, at a
                                             ///< wall, from the contact point

  bool at_wall() const { return antagonist < 0; }
  /// The two bodies, the same whichever grain is the candidate; walls are the negative ones.
  std::pair<Index, Index> bodies() const {
    return at_wall() ? std::pair{-1 - wall, candidate} : std::minmax({candidate, antagonist});
  }
};

/// All that the micromechanical observers need of a packing, whatever its grains and contacts are made of.
template <int Dim>
requires SupportedDimension<Dim>
struct ContactNetwork {
  Array<double> diameters = {};            ///< of the undeformed grains, > 0
  Array<ContactForce<Dim>> contacts = {};  ///< each contact once, in any order
  double volume = 0;                       ///< of the box or periodic cell (area in 2D), > 0

  Index n_grains() const { return diameters.size(); }
};

/// Throws InvalidInput when the network cannot be one: no grain, no volume, a contact with no grain, with
/// both a grain and a wall opposite, or with a number that is not finite.
template <int Dim>
void require_valid(const ContactNetwork<Dim>& network) {
  require(network.n_grains() > 0, "contact network: there is no grain");
  require(network.volume > 0 && std::isfinite(network.volume),
          "contact network: the volume must be positive and finite");
  for (const double d : network.diameters)
    require(d > 0 && std::isfinite(d), "contact network: diameters must be positive and finite");
  for (Index c = 0; c < network.contacts.size(); ++c) {
    const auto& contact = network.contacts[c];
    const bool one_opposite = (contact.antagonist < 0) != (contact.wall < 0);
    if (contact.candidate < 0 || contact.candidate >= network.n_grains() ||
        contact.antagonist >= network.n_grains() || !one_opposite || !contact.force.allFinite() ||
        !contact.branch.allFinite())
      throw InvalidInput("contact network: contact " + std::to_string(c) +
                         " must join a grain to one grain or one wall, with a finite force and branch");
  }
}

/// <d>.
template <int Dim>
double mean_diameter(const ContactNetwork<Dim>& network) {
  double sum = 0;
  for (const double d : network.diameters) sum += d;
  return sum / static_cast<double>(network.n_grains());
}

/// Sum of |forces| on each grain.
template <int Dim>
Array<double> force_sums(const ContactNetwork<Dim>& network) {
  Array<double> sums(network.n_grains(), 0.0);
  for (const auto& contact : network.contacts) {
    sums[contact.candidate] += contact.force.norm();
    if (!contact.at_wall()) sums[contact.antagonist] += contact.force.norm();
  }
  return sums;
}

/// Largest |sum of forces| / sum of |forces| over the grains not marked in `is_loose`.
template <int Dim>
double grain_imbalance(const ContactNetwork<Dim>& network, const Array<char>& is_loose) {
  Array<Vector<Dim>> net(network.n_grains(), Vector<Dim>::Zero());
  for (const auto& contact : network.contacts) {
    net[contact.candidate] += contact.force;
    if (!contact.at_wall()) net[contact.antagonist] -= contact.force;
  }
  const auto sums = force_sums(network);
  double imbalance = 0.0;
  for (Index i = 0; i < network.n_grains(); ++i)
    if (!is_loose[i] && sums[i] > 0) imbalance = std::max(imbalance, net[i].norm() / sums[i]);
  return imbalance;
}

}  // namespace jampack
