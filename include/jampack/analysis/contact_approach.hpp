// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/analysis/contact_network.hpp>

namespace jampack {

/// Unit normal of a contact as its branch and force have it, towards the candidate: along the centres of two
/// grains; at a wall, which has no friction, along its force.
template <int Dim>
Vector<Dim> contact_normal(const ContactForce<Dim>& contact) {
  return (contact.at_wall() ? contact.force : contact.branch).normalized();
}

/// Force along that normal, positive when it pushes the bodies apart.
template <int Dim>
double normal_force(const ContactForce<Dim>& contact) {
  return contact.force.dot(contact_normal(contact));
}

/// delta, by how much two centres are nearer than the sum of the undeformed radii, or a centre is nearer to
/// a wall than its radius; negative where they are farther.
template <int Dim>
double contact_approach(const ContactNetwork<Dim>& network, const ContactForce<Dim>& contact) {
  double radii = network.diameters[contact.candidate] / 2;
  if (!contact.at_wall()) radii += network.diameters[contact.antagonist] / 2;
  return radii - contact.branch.dot(contact_normal(contact));
}

/// delta over the diameters that share it: by how much of its diameter each grain gives way. Two equal grains
/// are each as a grain on the plane between them, so contacts with grains and with walls compare by it.
template <int Dim>
double approach_over_diameter(const ContactNetwork<Dim>& network, const ContactForce<Dim>& contact) {
  double diameters = network.diameters[contact.candidate];
  if (!contact.at_wall()) diameters += network.diameters[contact.antagonist];
  return contact_approach(network, contact) / diameters;
}

}  // namespace jampack
