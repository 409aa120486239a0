// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/analysis/contact_network.hpp>
#include <jampack/body/soft_packing.hpp>
#include <jampack/detection/surface_contact.hpp>
#include <map>

namespace jampack {

/// The contact network of a packing of deformable grains: all contact points of two grains summed into one
/// contact, those of a grain and a wall likewise. The branch of a wall contact starts at the point where
/// the summed force acts along the wall.
template <class Packing, int Dim, int N>
ContactNetwork<Dim> contact_network(const Packing& packing, const SurfaceContacts<Dim, N>& pairs,
                                    const SurfaceContacts<Dim, 1>& walls) {
  ContactNetwork<Dim> network;
  network.volume = packing.room.volume();
  Array<Vector<Dim>> centre;
  for (const auto& grain : packing.grains) {
    network.diameters.push_back(grain.diameter);
    centre.push_back(grain.centre());
  }
  std::map<std::pair<Index, Index>, Vector<Dim>> between;
  for (Index c = 0; c < pairs.size(); ++c) {
    const auto& contact = pairs.contact[c];
    const Vector<Dim> force = pairs.force(c);
    if (force.isZero(0)) continue;
    const bool ordered = contact.candidate < contact.antagonist;
    const auto key = std::minmax(contact.candidate, contact.antagonist);
    auto& sum = between.try_emplace({key.first, key.second}, Vector<Dim>::Zero()).first->second;
    sum += ordered ? force : Vector<Dim>(-force);
  }
  for (const auto& [key, force] : between) {
    ContactForce<Dim> contact;
    contact.candidate = key.first;
    contact.antagonist = key.second;
    contact.force = force;
    contact.branch = centre[key.first] - centre[key.second];
    network.contacts.push_back(contact);
  }
  struct WallSum {
    double force = 0;
    Vector<Dim> moment = Vector<Dim>::Zero();
  };
  std::map<std::pair<Index, Index>, WallSum> at_wall;
  for (Index c = 0; c < walls.size(); ++c) {
    const auto& contact = walls.contact[c];
    const double force = walls.reaction[c][0];
    if (force == 0) continue;
    auto& sum = at_wall[{contact.candidate, contact.wall()}];
    sum.force += force;
    sum.moment += force * weighted_point(contact.own, packing.grains[contact.candidate].position);
  }
  for (const auto& [key, sum] : at_wall) {
    ContactForce<Dim> contact;
    contact.candidate = key.first;
    contact.wall = key.second;
    contact.force = sum.force * packing.room.normal[key.second];
    contact.branch = centre[key.first] - sum.moment / sum.force;
    network.contacts.push_back(contact);
  }
  return network;
}

}  // namespace jampack
