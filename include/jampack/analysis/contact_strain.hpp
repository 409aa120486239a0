// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/analysis/contact_approach.hpp>

namespace jampack {

/// Mean contact strain <delta> / <d> over the contacts between grains that carry more than `threshold`, walls
/// apart; delta is the approach of two centres (contact_approach) and may be negative. 0 when there is no
/// such contact.
template <int Dim>
double contact_strain(const ContactNetwork<Dim>& network, double threshold = 0) {
  require_valid(network);
  double sum = 0, count = 0;
  for (const auto& contact : network.contacts)
    if (!contact.at_wall() && contact.force.norm() > threshold) {
      sum += contact_approach(network, contact);
      count += 1;
    }
  return count > 0 ? sum / count / mean_diameter(network) : 0.0;
}

}  // namespace jampack
