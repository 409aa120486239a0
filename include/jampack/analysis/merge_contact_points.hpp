// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <jampack/analysis/contact_network.hpp>
#include <jampack/core/array.hpp>
#include <unordered_map>
#include <utility>

namespace jampack {

/// Sums the contact points of each grain pair, and of each grain and wall, into one contact.
///
/// Points are given as contacts, in either order of the two grains; the merged contact keeps the order of the
/// first point, and contacts come in the order of their first points. The branch is the mean of the points'
/// weighted by the norm of their forces (plain mean where there is no force): between grains they are all
/// equal, and at a frictionless flat wall this keeps sum f (x) branch, hence the granular stress, exactly.
/// Not for periodic cells, where one pair of grains may touch through several images.
template <int Dim>
Array<ContactForce<Dim>> merge_contact_points(const Array<ContactForce<Dim>>& points) {
  struct Weights {
    double force = 0, count = 0;
    Vector<Dim> by_force = Vector<Dim>::Zero(), by_count = Vector<Dim>::Zero();
  };
  struct Hash {
    std::size_t operator()(const std::pair<Index, Index>& key) const {
      return std::hash<Index>()(key.first) * 0x9e3779b97f4a7c15ULL + std::hash<Index>()(key.second);
    }
  };
  Array<ContactForce<Dim>> merged;
  Array<Weights> weights;
  std::unordered_map<std::pair<Index, Index>, Index, Hash> place;
  for (const auto& point : points) {
    const auto [found, is_new] = place.try_emplace(point.bodies(), merged.size());
    if (is_new) {
      merged.push_back({.candidate = point.candidate, .antagonist = point.antagonist, .wall = point.wall});
      weights.push_back({});
    }
    auto& contact = merged[found->second];
    auto& weight = weights[found->second];
    const double sign = point.candidate == contact.candidate ? 1.0 : -1.0;
    const double force = point.force.norm();
    contact.force += sign * point.force;
    weight.force += force;
    weight.count += 1;
    weight.by_force += sign * force * point.branch;
    weight.by_count += sign * point.branch;
  }
  for (Index c = 0; c < merged.size(); ++c)
    merged[c].branch = weights[c].force > 0 ? Vector<Dim>(weights[c].by_force / weights[c].force)
                                            : Vector<Dim>(weights[c].by_count / weights[c].count);
  return merged;
}

}  // namespace jampack
