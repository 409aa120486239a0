// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/analysis/contact_network.hpp>
#include <jampack/analysis/granular_stress.hpp>
#include <jampack/analysis/rattlers.hpp>
#include <jampack/core/array.hpp>

namespace jampack {

/// Contacts of a set of grains.
struct ContactCount {
  Index n_grains = 0;
  Index n_grain_contacts = 0;  ///< between two grains of the set
  Index n_wall_contacts = 0;

  /// Z = 2 N_c / N_p, contacts between grains only; 0 for no grain.
  double coordination() const { return per_grain(2 * n_grain_contacts); }
  /// Contacts a grain has on average, with walls: (2 N_gg + N_w) / N_p.
  double coordination_with_walls() const { return per_grain(2 * n_grain_contacts + n_wall_contacts); }

 private:
  double per_grain(Index n) const {
    return n_grains > 0 ? static_cast<double>(n) / static_cast<double>(n_grains) : 0.0;
  }
};

/// Coordination of a packing. Z0 of small boxed packings is low because grains at walls and rattlers have few
/// neighbours, so the three are kept apart. Without friction and just jammed,
/// held.n_grain_contacts + held.n_wall_contacts = Dim held.n_grains (plus one for each independently driven
/// wall mode).
struct Coordination {
  ContactCount all;      ///< every grain
  ContactCount held;     ///< grains that are no rattlers, and the contacts among them and with walls
  double threshold = 0;  ///< force above which a contact counts
};

/// Counts contacts that carry more than 1e-4 P <d>^(D-1). least_contacts: see contacts_to_hold. Throws
/// InvalidInput as require_valid.
template <int Dim>
Coordination coordination(const ContactNetwork<Dim>& network, Index least_contacts) {
  Coordination result;
  result.threshold = contact_threshold(network);
  const Array<char> is_rattler = find_rattlers(network, least_contacts, result.threshold);
  result.all.n_grains = network.n_grains();
  for (const char rattler : is_rattler) result.held.n_grains += rattler ? 0 : 1;
  for (const auto& contact : network.contacts) {
    if (contact.force.norm() <= result.threshold) continue;
    const bool held =
        !is_rattler[contact.candidate] && (contact.at_wall() || !is_rattler[contact.antagonist]);
    const auto count = [&](ContactCount& set) {
      ++(contact.at_wall() ? set.n_wall_contacts : set.n_grain_contacts);
    };
    count(result.all);
    if (held) count(result.held);
  }
  return result;
}

}  // namespace jampack
