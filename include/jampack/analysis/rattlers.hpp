// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/analysis/contact_network.hpp>
#include <jampack/core/array.hpp>
#include <jampack/core/dimension.hpp>

namespace jampack {

/// Contacts, walls included, without which a grain cannot be held. Without friction the normals of a held
/// grain positively span the space, which takes Dim + 1 of them. With friction two opposite contacts hold a
/// grain, as each may push along the line that joins them; fewer cannot.
template <int Dim>
constexpr Index contacts_to_hold(bool frictional) {
  return frictional ? 2 : Dim + 1;
}

/// Marks rattlers (1, others 0): grains held by fewer than `least_contacts` contacts that carry more than
/// `threshold`. A rattler's contacts do not hold its neighbours either, so grains are removed until none is
/// left to remove; the order does not matter. It is a necessary condition for being held, not a sufficient
/// one.
template <int Dim>
Array<char> find_rattlers(const ContactNetwork<Dim>& network, Index least_contacts, double threshold = 0) {
  require_valid(network);
  Array<char> is_rattler(network.n_grains(), 0);
  Array<Index> n_contacts(network.n_grains());
  bool removed = true;
  while (removed) {
    n_contacts.assign(network.n_grains(), 0);
    for (const auto& contact : network.contacts) {
      if (contact.force.norm() <= threshold || is_rattler[contact.candidate]) continue;
      if (!contact.at_wall() && is_rattler[contact.antagonist]) continue;
      ++n_contacts[contact.candidate];
      if (!contact.at_wall()) ++n_contacts[contact.antagonist];
    }
    removed = false;
    for (Index i = 0; i < network.n_grains(); ++i)
      if (!is_rattler[i] && n_contacts[i] < least_contacts) {
        is_rattler[i] = 1;
        removed = true;
      }
  }
  return is_rattler;
}

}  // namespace jampack
