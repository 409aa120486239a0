// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <bit>
#include <jampack/problem/stored_blocks.hpp>
#include <jampack/solver/contact_groups.hpp>
#include <numeric>

namespace jampack {

/// Contacts in classes within which no update reads what another one writes, so that a class may be shared
/// out among threads and the result is the same, bit by bit, whatever their number. What is kept apart are
/// pairs of bodies (all contacts of a pair stay together, in their order). The first class holds one long
/// chunk for each of a few regions of the packing, whose bodies a thread then keeps in its cache. Then come
/// the contacts between two regions, one chunk for each two, in classes in which no region occurs twice: a
/// few classes, as threads meet after each. What is left (small packings, a wall that moves) follows colour
/// by colour.
///
/// A body with very many contacts (a wall that moves) does not hinder a class: its contacts there are one
/// chunk, hence one thread's. Classes too small to be shared are joined and left to one thread.
struct Colouring {
  struct Chunk {
    Index first, last;                     ///< places in `order`, last not included
    Index region = -1, other_region = -1;  ///< whose bodies it moves; -1: of any
  };
  struct Class {
    Index first, last;  ///< chunks, last not included
    bool shared;        ///< chunks may be visited at once; otherwise one after the other
  };
  Array<Index> order;  ///< contacts as visited
  Array<Chunk> chunks;
  Array<Class> classes;
  Index n_regions = 0;
};

namespace detail {

/// Cuts bodies (or contacts) into compact regions by halving, breadth first from one end: region of each.
class Regions {
 public:
  Regions(const Array<Array<Index>>& neighbours, Index n_halvings)
      : neighbours_(neighbours), region_(neighbours.size(), Index{0}), seen_(neighbours.size(), Index{-1}) {
    Array<Index> all(neighbours.size());
    std::iota(all.begin(), all.end(), Index{0});
    halve(all, n_halvings);
  }
  Index operator[](Index body) const { return region_[body]; }

 private:
  void halve(Array<Index> bodies, Index n_halvings) {
    if (n_halvings == 0 || bodies.size() < 2) {
      for (const Index b : bodies) region_[b] = n_regions_;
      ++n_regions_;
      return;
    }
    const Index mark = ++mark_;
    for (const Index b : bodies) region_[b] = -mark;
    // From the body found last, which lies at an end.
    bodies = breadth_first(bodies, breadth_first(bodies, bodies.front(), mark).back(), mark);
    const auto middle = bodies.begin() + bodies.size() / 2;
    halve(Array<Index>(bodies.begin(), middle), n_halvings - 1);
    halve(Array<Index>(middle, bodies.end()), n_halvings - 1);
  }

  Array<Index> breadth_first(const Array<Index>& bodies, Index start, Index mark) {
    const Index visit = n_visits_++;
    Array<Index> order;
    Index next = 0;
    const auto add = [&](Index b) {
      if (seen_[b] == visit || region_[b] != -mark) return;
      seen_[b] = visit;
      order.push_back(b);
    };
    add(start);
    for (Index k = 0; order.size() < bodies.size(); ++k) {
      if (k == order.size())
        while (order.size() == k) add(bodies[next++]);  // another part
      for (const Index b : neighbours_[order[k]]) add(b);
    }
    return order;
  }

  const Array<Array<Index>>& neighbours_;
  Array<Index> region_, seen_;
  Index mark_ = 0, n_visits_ = 0, n_regions_ = 0;
};

/// Appends the groups as one chunk.
inline void add_chunk(Colouring& colouring, const Array<const ContactGroup*>& members, Index region,
                      Index other_region) {
  const Index start = colouring.order.size();
  for (const auto* group : members)
    for (const Index c : group->contacts) colouring.order.push_back(c);
  colouring.chunks.push_back({start, colouring.order.size(), region, other_region});
}

/// The contacts inside each region.
inline void add_regions(Colouring& colouring, const Array<Array<const ContactGroup*>>& inside) {
  colouring.n_regions = inside.size();
  for (Index k = 0; k < inside.size(); ++k)
    if (!inside[k].empty()) add_chunk(colouring, inside[k], k, k);
  if (!colouring.chunks.empty()) colouring.classes.push_back({0, colouring.chunks.size(), true});
}

/// Contacts between two regions.
struct Interface {
  Index first, second;  ///< regions
  Array<const ContactGroup*> members = {};
  Index size = 0;  ///< contacts
};

/// The class for so many contacts in so many parts: a new one, or the last, where both are too small to be
/// shared out.
inline Colouring::Class& class_for(Colouring& colouring, Index n_contacts, Index n_parts) {
  constexpr Index least_shared = 64;
  const bool shared = n_contacts >= least_shared && n_parts > 1;
  if (shared || colouring.classes.empty() || colouring.classes.back().shared)
    colouring.classes.push_back({colouring.chunks.size(), colouring.chunks.size(), shared});
  return colouring.classes.back();
}

/// Interfaces in classes: first those between regions that were parted last, which are the same thread's,
/// then large ones first, so that those of a class are much alike.
inline void add_interfaces(Colouring& colouring, Array<Interface> interfaces, Index n_regions) {
  std::stable_sort(interfaces.begin(), interfaces.end(), [](const Interface& a, const Interface& b) {
    const auto parted = [](const Interface& one) {
      return std::bit_width(static_cast<std::size_t>(one.first ^ one.second));
    };
    return parted(a) != parted(b) ? parted(a) < parted(b) : a.size > b.size;
  });
  while (!interfaces.empty()) {
    Array<char> taken(n_regions, 0);
    Array<Interface> members, others;
    Index size = 0;
    for (Interface& one : interfaces) {
      if (taken[one.first] != 0 || taken[one.second] != 0) {
        others.push_back(std::move(one));
        continue;
      }
      taken[one.first] = taken[one.second] = 1;
      size += one.size;
      members.push_back(std::move(one));
    }
    // In the order of the regions, so that a thread meets those it has in its cache.
    std::stable_sort(members.begin(), members.end(), [](const Interface& a, const Interface& b) {
      return a.first + a.second < b.first + b.second;
    });
    Colouring::Class& one_class = class_for(colouring, size, members.size());
    for (const Interface& one : members) add_chunk(colouring, one.members, one.first, one.second);
    one_class.last = colouring.chunks.size();
    interfaces = std::move(others);
  }
}

/// Groups that may be visited at once.
inline void add_class(Colouring& colouring, const Array<const ContactGroup*>& members, Index chunk_size) {
  Index size = 0;
  for (const auto* group : members) size += group->contacts.size();
  Colouring::Class& one_class = class_for(colouring, size, members.size());
  Index start = colouring.order.size();
  for (Index k = 0; k < members.size(); ++k) {
    for (const Index c : members[k]->contacts) colouring.order.push_back(c);
    const bool at_end = k + 1 == members.size();
    const bool other_hub = at_end || members[k]->hub != members[k + 1]->hub;
    const bool full = members[k]->hub < 0 && colouring.order.size() - start >= chunk_size;
    if (!other_hub && !full) continue;
    colouring.chunks.push_back({start, colouring.order.size(), -1, -1});
    start = colouring.order.size();
  }
  one_class.last = colouring.chunks.size();
}

}  // namespace detail

/// Colours the contacts of any Delassus operator, in their order: by for_each_body(c, visit) where it has it
/// (contacts with a common body are kept apart), else by the blocks of W. Depends on the scene alone.
template <DelassusOperator Delassus>
Colouring colour_contacts(const Delassus& delassus) {
  Array<ContactGroup> groups;
  Array<Array<const ContactGroup*>> classes;  // by colour
  Colouring colouring;
  const auto put = [&](const ContactGroup& group, const Array<char>& taken) {
    Index colour = 0;
    while (taken[colour] != 0) ++colour;
    if (colour == classes.size()) classes.push_back({});
    classes[colour].push_back(&group);
    return colour;
  };
  if constexpr (requires { delassus.for_each_body(Index{}, [](Index) {}); }) {
    groups = group_contacts(delassus);
    const Index n_bodies = count_bodies(groups);
    spare_hubs(groups, n_bodies);
    const Index n_halvings = n_bodies >= 512 ? 3 : n_bodies >= 128 ? 2 : n_bodies >= 32 ? 1 : 0;
    Array<Array<Index>> neighbours(n_bodies);
    for (const auto& group : groups)
      for (const Index a : group.bodies)
        for (const Index b : group.bodies)
          if (a != b) neighbours[a].push_back(b);
    const detail::Regions region(neighbours, n_halvings);
    const Index n_regions = Index{1} << n_halvings;
    Array<Array<const ContactGroup*>> inside(n_regions);
    Array<detail::Interface> between;
    Array<Index> interface_of(n_regions * n_regions, Index{-1});
    Array<Array<Index>> colours_of_body(n_bodies);
    for (const auto& group : groups) {
      const auto& bodies = group.bodies;
      if (n_halvings > 0 && group.hub < 0 && !bodies.empty()) {
        const auto [least, most] = std::minmax({region[bodies.front()], region[bodies.back()]});
        if (least == most) {
          inside[least].push_back(&group);
          continue;
        }
        Index& k = interface_of[least * n_regions + most];
        if (k < 0) {
          k = between.size();
          between.push_back({least, most});
        }
        between[k].members.push_back(&group);
        between[k].size += group.contacts.size();
        continue;
      }
      Array<char> taken(classes.size() + 1, 0);
      for (const Index body : bodies)
        for (const Index colour : colours_of_body[body]) taken[colour] = 1;
      const Index colour = put(group, taken);
      for (const Index body : bodies) colours_of_body[body].push_back(colour);
    }
    detail::add_regions(colouring, inside);
    detail::add_interfaces(colouring, std::move(between), n_regions);
    // Groups of one hub lie together; the others by region.
    for (auto& members : classes)
      std::stable_sort(members.begin(), members.end(), [&](const auto* a, const auto* b) {
        const auto where = [&](const auto* group) {
          return group->bodies.empty() ? 0 : region[group->bodies.front()];
        };
        return a->hub != b->hub ? a->hub > b->hub : where(a) < where(b);
      });
  } else {
    const Index n = delassus.n_contacts();
    Array<Array<Index>> neighbours(n);
    for (const auto& block : stored_blocks(delassus)) {
      neighbours[block.row].push_back(block.column);
      neighbours[block.column].push_back(block.row);
    }
    Array<Index> colour(n, Index{-1});
    for (Index c = 0; c < n; ++c) groups.push_back({{}, {c}, -1});
    // Whoever is coupled within a region only is visited with it.
    const Index n_halvings = n >= 2048 ? 3 : n >= 1024 ? 2 : n >= 512 ? 1 : 0;
    const detail::Regions region(neighbours, n_halvings);
    Array<Array<const ContactGroup*>> inside(Index{1} << n_halvings);
    for (Index c = 0; c < n; ++c) {
      const bool one_region = std::all_of(neighbours[c].begin(), neighbours[c].end(),
                                          [&](Index d) { return region[d] == region[c]; });
      if (n_halvings > 0 && one_region) {
        inside[region[c]].push_back(&groups[c]);
        continue;
      }
      Array<char> taken(classes.size() + 1, 0);
      for (const Index d : neighbours[c])
        if (colour[d] >= 0) taken[colour[d]] = 1;
      colour[c] = put(groups[c], taken);
    }
    detail::add_regions(colouring, inside);
  }
  for (const auto& members : classes) detail::add_class(colouring, members, 16);
  return colouring;
}

}  // namespace jampack
