// SPDX-License-Identifier: MIT
#pragma once

#include <iterator>
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
  const auto join = [](auto& parts, auto& all) {
    Index size = 0;
    for (const auto& part : parts) size += part.size();
    all.reserve(size);
    for (auto& part : parts)
      all.insert(all.end(), std::make_move_iterator(part.begin()), std::make_move_iterator(part.end()));
  };
  join(found_pairs, pairs);
  join(found_walls, walls);
}

/// Replaces contacts of a set by fresh ones of the same samples (both lists sorted by key), keeping the
/// reactions of those that stay; what a sample carried on faces it has left goes to the one it is above.
/// Samples that are not among the fresh ones stay as they are if `stays(first, end)`, their contacts in the
/// set, is true. Returns the first contact of each that stayed so.
template <int Dim, int N, class Stays>
Array<Index> merge_contacts(SurfaceContacts<Dim, N>& set, Array<SurfaceContact<Dim>> fresh, Stays stays) {
  struct Piece {
    Index first, end;  ///< contacts of the set
    Index before;      ///< fresh one that comes next
  };
  Array<Piece> kept;
  Array<ContactVector<N>> reaction(fresh.size(), ContactVector<N>::Zero());
  Index old = 0, n_kept = 0;
  const auto pass = [&](Index before) {
    const Index end = end_of_sample(set.contact, old);
    if (stays(old, end)) {
      kept.push_back({old, end, before});
      n_kept += end - old;
    }
    old = end;
  };
  for (Index first = 0; first < fresh.size();) {
    const Index end = end_of_sample(fresh, first);
    while (old < set.size() && set.contact[old].key() < fresh[first].key()) pass(first);
    if (old < set.size() && set.contact[old].key() == fresh[first].key())
      for (const Index old_end = end_of_sample(set.contact, old); old < old_end; ++old) {
        Index same = first;
        while (same < end && fresh[same].face != set.contact[old].face) ++same;
        reaction[same < end ? same : first] += set.reaction[old];
      }
    first = end;
  }
  while (old < set.size()) pass(fresh.size());
  if (kept.empty()) {
    set.contact = std::move(fresh);
    set.reaction = std::move(reaction);
    return {};
  }
  SurfaceContacts<Dim, N> merged;
  merged.contact.reserve(fresh.size() + n_kept);
  merged.reaction.reserve(fresh.size() + n_kept);
  const auto take = [&](Array<SurfaceContact<Dim>>& contact, const auto& force, Index first, Index end) {
    merged.contact.insert(merged.contact.end(), std::make_move_iterator(contact.begin() + first),
                          std::make_move_iterator(contact.begin() + end));
    merged.reaction.insert(merged.reaction.end(), force.begin() + first, force.begin() + end);
  };
  Array<Index> where;
  Index next = 0;
  for (const Piece& piece : kept) {
    take(fresh, reaction, next, piece.before);
    next = piece.before;
    where.push_back(merged.size());
    take(set.contact, set.reaction, piece.first, piece.end);
  }
  take(fresh, reaction, next, fresh.size());
  set = std::move(merged);
  return where;
}

/// Replaces all contacts of a set, as merge_contacts() does. A sample that goes while it carries a force is
/// kept with its contacts, as only the solver may release it; returned is the first contact of each of those.
template <int Dim, int N>
Array<Index> replace_contacts(SurfaceContacts<Dim, N>& set, Array<SurfaceContact<Dim>> fresh) {
  return merge_contacts(set, std::move(fresh), [&](Index first, Index end) {
    return std::any_of(set.reaction.begin() + first, set.reaction.begin() + end,
                       [](const auto& r) { return !r.isZero(0); });
  });
}

}  // namespace jampack
