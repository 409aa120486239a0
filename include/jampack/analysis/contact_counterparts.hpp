// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/analysis/contact_network.hpp>
#include <map>

namespace jampack {

/// For every contact of `network` the index of the contact of the same two bodies in `other`, -1 where they
/// have none there: two models of one packing are compared contact by contact. Grains and walls have the same
/// numbers in both; which grain of a contact is the candidate does not matter. Throws InvalidInput when the
/// numbers of grains differ, or `other` has two contacts of the same bodies (merge_contact_points makes them
/// one).
template <int Dim>
Array<Index> contact_counterparts(const ContactNetwork<Dim>& network, const ContactNetwork<Dim>& other) {
  require(network.n_grains() == other.n_grains(),
          "contact counterparts: the networks must have the same grains");
  std::map<std::pair<Index, Index>, Index> place;
  for (Index c = 0; c < other.contacts.size(); ++c)
    require(place.try_emplace(other.contacts[c].bodies(), c).second,
            "contact counterparts: contact " + std::to_string(c) + " has the same bodies as one before it");
  Array<Index> counterparts;
  for (const auto& contact : network.contacts) {
    const auto found = place.find(contact.bodies());
    counterparts.push_back(found == place.end() ? -1 : found->second);
  }
  return counterparts;
}

}  // namespace jampack
