// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <jampack/analysis/contact_network.hpp>
#include <jampack/core/dimension.hpp>
#include <numbers>

namespace jampack {

/// Granular stress sigma_ab = (1/V) sum over contacts of f_a branch_b, compression positive; wall contacts
/// are in the sum, or it does not close. Paper label eq:sigma, docs/theory/compaction_laws.md (1).
///
/// It is symmetric where the contact forces turn no grain about its centre. Once every grain is in balance it
/// equals the stress the walls exert, whatever the centres are. Throws InvalidInput as require_valid.
template <int Dim>
Matrix<Dim> granular_stress(const ContactNetwork<Dim>& network) {
  require_valid(network);
  Matrix<Dim> sum = Matrix<Dim>::Zero();
  for (const auto& contact : network.contacts) sum += contact.force * contact.branch.transpose();
  return sum / network.volume;
}

/// Mean stress P = tr sigma / D.
template <int Dim>
double granular_pressure(const ContactNetwork<Dim>& network) {
  return granular_stress(network).trace() / Dim;
}

/// Force above which a contact is counted, 1e-4 P <d>^(D-1) (zero in a packing that is not compressed).
template <int Dim>
double contact_threshold(const ContactNetwork<Dim>& network) {
  return 1e-4 * std::max(0.0, granular_pressure(network)) * std::pow(mean_diameter(network), Dim - 1);
}

/// Largest |sum of forces| / sum of |forces| over the grains whose forces together count as a contact.
template <int Dim>
double grain_imbalance(const ContactNetwork<Dim>& network) {
  const double counts = contact_threshold(network);
  Array<char> is_loose;
  for (const double sum : force_sums(network)) is_loose.push_back(sum <= counts);
  return grain_imbalance(network, is_loose);
}

/// Mean contact stress sigma_l = <f . branch> / <d>^D over the contacts between grains that carry more than
/// `threshold`; 0 when there is none.
template <int Dim>
double mean_contact_stress(const ContactNetwork<Dim>& network, double threshold = 0) {
  require_valid(network);
  double sum = 0, count = 0;
  for (const auto& contact : network.contacts)
    if (!contact.at_wall() && contact.force.norm() > threshold) {
      sum += contact.force.dot(contact.branch);
      count += 1;
    }
  return count > 0 ? sum / count / std::pow(mean_diameter(network), Dim) : 0.0;
}

/// <d>^D / <d^D>: 1 for equal grains, 1/1.04 in 3D and 1/1.01333 in 2D for d uniform in [0.8, 1.2] <d>.
template <int Dim>
double polydispersity_factor(const ContactNetwork<Dim>& network) {
  double sum = 0;
  for (const double d : network.diameters) sum += std::pow(d, Dim);
  return std::pow(mean_diameter(network), Dim) / (sum / static_cast<double>(network.n_grains()));
}

/// P = phi Z sigma_l / pi, in 2D as in 3D, times polydispersity_factor where grains are not equal: P written
/// through the microstructure, for a packing without walls whose phi counts undeformed volumes. Paper label
/// eq:Pglobal_local_contact, docs/theory/compaction_laws.md (2).
inline double pressure_from_contact_stress(double phi, double z, double mean_contact_stress,
                                           double polydispersity_factor = 1) {
  return phi * z * mean_contact_stress * polydispersity_factor / std::numbers::pi;
}

}  // namespace jampack
