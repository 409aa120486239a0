// SPDX-License-Identifier: MIT
#pragma once

#ifdef _OPENMP
#include <omp.h>
#endif

#include <algorithm>
#include <jampack/core/parallel.hpp>
#include <jampack/problem/stored_blocks.hpp>
#include <jampack/solver/contact_groups.hpp>
#include <utility>

namespace jampack {

/// Contacts in classes within which no update reads what another one writes, so that a class may be shared
/// out among threads and the result is the same, bit by bit, whatever their number. What is kept apart are
/// pairs of bodies (all contacts of a pair stay together, in their order). The first class holds one long
/// chunk for each of a few regions of the packing, whose bodies a thread then keeps in its cache; the pairs
/// between regions follow, colour by colour.
///
/// A body with very many contacts (a wall that moves) does not hinder a class: its contacts there are one
/// chunk, hence one thread's. Classes too small to be shared are joined and left to one thread.
struct Colouring {
  struct Chunk {
    Index first, last;  ///< places in `order`, last not included
  };
  struct Class {
    Index first, last;  ///< chunks, last not included
    bool shared;        ///< chunks may be visited at once; otherwise one after the other
  };
  Array<Index> order;  ///< contacts as visited
  Array<Chunk> chunks;
  Array<Class> classes;
};

namespace detail {

/// Cuts the bodies into compact regions by halving, breadth first from one end: region of each body.
class Regions {
 public:
  Regions(const Array<ContactGroup>& groups, Index n_bodies, Index n_halvings)
      : neighbours_(n_bodies), region_(n_bodies, Index{0}), seen_(n_bodies, Index{-1}) {
    for (const auto& group : groups)
      for (const Index a : group.bodies)
        for (const Index b : group.bodies)
          if (a != b) neighbours_[a].push_back(b);
    Array<Index> all(n_bodies);
    for (Index b = 0; b < n_bodies; ++b) all[b] = b;
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

  Array<Array<Index>> neighbours_;
  Array<Index> region_, seen_;
  Index mark_ = 0, n_visits_ = 0, n_regions_ = 0;
};

/// Classes of groups into a colouring.
inline void add_class(Colouring& colouring, const Array<const ContactGroup*>& members, Index chunk_size) {
  constexpr Index least_shared = 64;
  Index size = 0;
  for (const auto* group : members) size += group->contacts.size();
  const bool shared = size >= least_shared && members.size() > 1;
  if (shared || colouring.classes.empty() || colouring.classes.back().shared)
    colouring.classes.push_back({colouring.chunks.size(), colouring.chunks.size(), shared});
  Index start = colouring.order.size();
  for (Index k = 0; k < members.size(); ++k) {
    for (const Index c : members[k]->contacts) colouring.order.push_back(c);
    const bool at_end = k + 1 == members.size();
    const bool other_hub = at_end || members[k]->hub != members[k + 1]->hub;
    const bool full = members[k]->hub < 0 && colouring.order.size() - start >= chunk_size;
    if (!other_hub && !full) continue;
    colouring.chunks.push_back({start, colouring.order.size()});
    start = colouring.order.size();
  }
  colouring.classes.back().last = colouring.chunks.size();
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
    const detail::Regions region(groups, n_bodies, n_halvings);
    Array<Array<const ContactGroup*>> inside(Index{1} << n_halvings);
    Array<Array<Index>> colours_of_body(n_bodies);
    for (const auto& group : groups) {
      const auto& bodies = group.bodies;
      const bool one_region = n_halvings > 0 && group.hub < 0 && !bodies.empty() &&
                              std::all_of(bodies.begin(), bodies.end(),
                                          [&](Index b) { return region[b] == region[bodies.front()]; });
      if (one_region) {
        inside[region[bodies.front()]].push_back(&group);
        continue;
      }
      Array<char> taken(classes.size() + 1, 0);
      for (const Index body : bodies)
        for (const Index colour : colours_of_body[body]) taken[colour] = 1;
      const Index colour = put(group, taken);
      for (const Index body : bodies) colours_of_body[body].push_back(colour);
    }
    colouring.classes.push_back({0, 0, true});
    for (const auto& members : inside) {
      if (members.empty()) continue;
      const Index start = colouring.order.size();
      for (const auto* group : members)
        for (const Index c : group->contacts) colouring.order.push_back(c);
      colouring.chunks.push_back({start, colouring.order.size()});
    }
    colouring.classes.back().last = colouring.chunks.size();
    if (colouring.chunks.empty()) colouring.classes.clear();
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
    for (Index c = 0; c < n; ++c) {
      Array<char> taken(classes.size() + 1, 0);
      for (const Index d : neighbours[c])
        if (colour[d] >= 0) taken[colour[d]] = 1;
      colour[c] = put(groups[c], taken);
    }
  }
  for (const auto& members : classes) detail::add_class(colouring, members, 16);
  return colouring;
}

/// Calls visit(k) for every chunk, class by class; the chunks of a class that may be shared by several
/// threads at once. No visit may throw.
template <class Visit>
void for_each_chunk(const Colouring& colouring, Threads threads, const Visit& visit) {
  // One thread's part. All threads meet after each class.
  const auto work = [&](Index thread, Index n_threads) {
    for (const Colouring::Class& colour : colouring.classes) {
      const Index begin = colouring.chunks[colour.first].first,
                  size = colouring.chunks[colour.last - 1].last - begin;
      const Index first = begin + size * thread / n_threads, last = begin + size * (thread + 1) / n_threads;
      for (Index k = colour.first; k < colour.last; ++k) {
        const auto& chunk = colouring.chunks[k];
        if (colour.shared ? chunk.first >= first && chunk.first < last : thread == 0) visit(k);
      }
#ifdef _OPENMP
#pragma omp barrier
#endif
    }
  };
#ifdef _OPENMP
  if (threads.count > 1) {
#pragma omp parallel num_threads(threads.count)
    work(omp_get_thread_num(), omp_get_num_threads());
    return;
  }
#else
  (void)threads;
#endif
  work(0, 1);
}

}  // namespace jampack
