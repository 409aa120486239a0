// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/core/parallel.hpp>
#include <jampack/detection/r_tree.hpp>
#include <jampack/detection/sampled_contact.hpp>

namespace jampack {

namespace detail {

/// Ball about a grain's boundary nodes; `slack` widens it for faces that bulge past their nodes.
template <int Dim>
void add_bounding_ball(const GrainSurface<Dim>& surface, double slack, Balls<Dim>& balls) {
  const auto& x = surface.position();
  Vector<Dim> centre = Vector<Dim>::Zero();
  for (const Index i : surface.boundary().nodes) centre += x.col(i) / double(surface.boundary().nodes.size());
  double radius = 0;
  for (const Index i : surface.boundary().nodes) radius = std::max(radius, (x.col(i) - centre).norm());
  balls.add(2 * (radius + slack), centre);
}

/// Of two grains the smaller, which has the finer mesh, leads: its nodes are held on the other's surface.
template <int Dim>
bool leads(const Array<GrainSurface<Dim>>& surfaces, Index a, Index b) {
  const double da = surfaces[a].diameter(), db = surfaces[b].diameter();
  return da < db || (da == db && a < b);
}

}  // namespace detail

/// Past the last contact of the sample and the grain that contact `first` of a list is of.
template <int Dim>
Index end_of_sample(const Array<SurfaceContact<Dim>>& contacts, Index first) {
  Index end = first + 1;
  while (end < contacts.size() && contacts[end].key() == contacts[first].key()) ++end;
  return end;
}

/// The contacts of a discretisation that are within range of another grain (`pairs`) or of a wall (`walls`),
/// sorted by key. Grains that may touch come from an R-tree over their bounding balls.
template <int Dim, ContactDiscretisation<Dim> Discretisation>
void detect(const Discretisation& discretisation, const Array<GrainSurface<Dim>>& surfaces,
            const Container<Dim>& room, const DetectionRange& range, Threads threads,
            Array<SurfaceContact<Dim>>& pairs, Array<SurfaceContact<Dim>>& walls) {
  const Index n = surfaces.size();
  Balls<Dim> bounds;
  for (const auto& surface : surfaces) detail::add_bounding_ball(surface, range.depth, bounds);
  Array<Array<Index>> neighbours(n);
  RTree<Dim> tree(0.0);
  for (const auto& pair : tree.pairs(bounds, range.reach)) {
    neighbours[pair.first].push_back(pair.second);
    neighbours[pair.second].push_back(pair.first);
  }

  Array<Array<SurfaceContact<Dim>>> found_pairs(n), found_walls(n);
  parallel_for(threads, n, [&](Index a) {
    const auto& surface = surfaces[a];
    std::sort(neighbours[a].begin(), neighbours[a].end());
    for (Index i = 0; i < discretisation.n_points(surface.boundary(), range.samples); ++i) {
      const auto place = discretisation.place(surface, i);
      SurfaceContact<Dim> contact;
      contact.candidate = a;
      contact.sample = i;
      for (const Index b : neighbours[a]) {
        if ((place.point - bounds.position[b]).norm() > 0.5 * bounds.diameter[b] + range.reach) continue;
        contact.antagonist = b;
        discretisation.find(place, surfaces[b], detail::leads(surfaces, a, b), range, contact,
                            found_pairs[a]);
      }
      for (Index w = 0; w < room.n_walls(); ++w) {
        contact.antagonist = -1 - w;
        discretisation.find_at_wall(place, room, range, contact, found_walls[a]);
      }
    }
    // Walls have descending negative keys: they come before grains and in reverse.
    std::sort(found_walls[a].begin(), found_walls[a].end(),
              [](const auto& p, const auto& q) { return p.key() < q.key(); });
  });
  pairs.clear();
  walls.clear();
  for (Index a = 0; a < n; ++a) {
    pairs.insert(pairs.end(), found_pairs[a].begin(), found_pairs[a].end());
    walls.insert(walls.end(), found_walls[a].begin(), found_walls[a].end());
  }
}

/// Replaces the contacts of a set, keeping the reactions of those that stay (both lists sorted by key); what
/// a sample carried on faces it has left goes to the one it is above. A sample that goes while it carries a
/// force is kept with its contacts: only the solver may release it.
template <int Dim, int N>
void replace_contacts(SurfaceContacts<Dim, N>& set, const Array<SurfaceContact<Dim>>& fresh) {
  SurfaceContacts<Dim, N> merged;
  Index old = 0;
  const auto keep_loaded = [&] {
    const Index end = end_of_sample(set.contact, old);
    const bool carries = std::any_of(set.reaction.begin() + old, set.reaction.begin() + end,
                                     [](const auto& r) { return !r.isZero(0); });
    for (; old < end; ++old)
      if (carries) {
        merged.contact.push_back(set.contact[old]);
        merged.reaction.push_back(set.reaction[old]);
      }
  };
  for (Index first = 0; first < fresh.size();) {
    const Index end = end_of_sample(fresh, first), begin = merged.size();
    while (old < set.size() && set.contact[old].key() < fresh[first].key()) keep_loaded();
    for (; first < end; ++first) {
      merged.contact.push_back(fresh[first]);
      merged.reaction.push_back(ContactVector<N>::Zero());
    }
    if (old == set.size() || set.contact[old].key() != merged.contact[begin].key()) continue;
    for (const Index old_end = end_of_sample(set.contact, old); old < old_end; ++old) {
      Index same = begin;
      while (same < merged.size() && merged.contact[same].face != set.contact[old].face) ++same;
      merged.reaction[same < merged.size() ? same : begin] += set.reaction[old];
    }
  }
  while (old < set.size()) keep_loaded();
  set = std::move(merged);
}

}  // namespace jampack
