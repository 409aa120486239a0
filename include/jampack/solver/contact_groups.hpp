// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <jampack/core/array.hpp>
#include <utility>

namespace jampack {

/// Contacts that have the same bodies.
struct ContactGroup {
  Array<Index> bodies;    // ascending; without the hub
  Array<Index> contacts;  // in their order
  Index hub = -1;         // its body with very many groups
};

/// The contacts of an operator that has for_each_body(c, visit), by their bodies.
template <class Delassus>
Array<ContactGroup> group_contacts(const Delassus& delassus) {
  Array<std::pair<Array<Index>, Index>> keyed;
  for (Index c = 0; c < delassus.n_contacts(); ++c) {
    Array<Index> bodies;
    delassus.for_each_body(c, [&](Index body) { bodies.push_back(body); });
    std::sort(bodies.begin(), bodies.end());
    keyed.push_back({std::move(bodies), c});
  }
  const auto less = [](const auto& a, const auto& b) {
    return std::lexicographical_compare(a.first.begin(), a.first.end(), b.first.begin(), b.first.end());
  };
  std::stable_sort(keyed.begin(), keyed.end(), less);
  Array<ContactGroup> groups;
  for (Index k = 0; k < keyed.size(); ++k) {
    if (k == 0 || less(keyed[k - 1], keyed[k])) groups.push_back({keyed[k].first, {}, -1});
    groups.back().contacts.push_back(keyed[k].second);
  }
  return groups;
}

/// One more than the last body.
inline Index count_bodies(const Array<ContactGroup>& groups) {
  Index n = 0;
  for (const auto& group : groups)
    if (!group.bodies.empty()) n = std::max(n, group.bodies.back() + 1);
  return n;
}

/// Takes bodies with very many groups out of `bodies`.
inline void spare_hubs(Array<ContactGroup>& groups, Index n_bodies) {
  constexpr Index many = 48;
  Array<Index> n_groups(n_bodies, Index{0});
  for (const auto& group : groups)
    for (const Index body : group.bodies) ++n_groups[body];
  // One hub at most: where two bodies have many contacts, they are kept apart like any others.
  Array<char> is_hub(n_bodies, 0);
  for (Index body = 0; body < n_bodies; ++body) is_hub[body] = n_groups[body] > many ? 1 : 0;
  for (const auto& group : groups)
    if (std::count_if(group.bodies.begin(), group.bodies.end(), [&](Index b) { return is_hub[b] != 0; }) > 1)
      for (const Index body : group.bodies) is_hub[body] = 0;
  for (auto& group : groups)
    for (Index k = 0; k < group.bodies.size(); ++k)
      if (is_hub[group.bodies[k]] != 0) {
        group.hub = group.bodies[k];
        group.bodies.erase(group.bodies.begin() + k);
        break;
      }
}

}  // namespace jampack
