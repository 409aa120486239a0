// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/core/parallel.hpp>
#include <jampack/detection/r_tree.hpp>
#include <jampack/detection/surface_contact.hpp>

namespace jampack {

/// What separates contacts worth watching from the rest.
struct DetectionRange {
  double reach = 0;  ///< samples nearer than this to another surface are kept, length
  double depth = 0;  ///< and none deeper than this: beyond it a sample belongs to the other side, length
  SampleSet samples = SampleSet::all;
};

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

/// The contacts of a sample at x, projected on the other grain, from a contact that knows all but its planes.
template <int Dim>
void add_contacts(SurfaceContact<Dim> contact, const GrainSurface<Dim>& other,
                  const typename GrainSurface<Dim>::Projection& p, const Vector<Dim>& x,
                  Array<SurfaceContact<Dim>>& contacts) {
  constexpr double crease = 0.02;  // so near to one over the diameter, a sample may come to lie in it
  for (const auto& plane : other.tangent_planes(x, p, crease * other.diameter())) {
    contact.hold(other, plane, x);
    contacts.push_back(contact);
  }
}

/// The samples asked for that are within range of another grain (`pairs`) or of a wall (`walls`), sorted by
/// key. Grains that may touch come from an R-tree over their bounding balls; a sample starts its walk to its
/// projection from the nearest node.
template <int Dim>
void detect(const Array<GrainSurface<Dim>>& surfaces, const Container<Dim>& room, const DetectionRange& range,
            Threads threads, Array<SurfaceContact<Dim>>& pairs, Array<SurfaceContact<Dim>>& walls) {
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
    const auto& samples = surface.boundary().samples;
    for (Index s = 0; s < surface.boundary().n_samples(range.samples); ++s) {
      const Vector<Dim> x = surface.sample_point(samples[s], surface.position());
      const Vector<Dim> outward = surface.sample_normal(samples[s]);
      SurfaceContact<Dim> contact;
      contact.candidate = a;
      contact.sample = s;
      for (const Index b : neighbours[a]) {
        if ((x - bounds.position[b]).norm() > 0.5 * bounds.diameter[b] + range.reach) continue;
        const auto& other = surfaces[b];
        const auto [node, distance] = other.nearest_node(x);
        const double edge = other.boundary().edge_length * bounds.diameter[b];
        if (std::sqrt(distance) > range.reach + range.depth + 2 * edge) continue;
        const auto p = other.project(x, node);
        contact.slack = surface.boundary().slack(s, detail::leads(surfaces, a, b)) * surface.diameter();
        if (!p.on_surface || p.gap + contact.slack > range.reach || p.gap < -range.depth ||
            outward.dot(p.normal) > 0.5)
          continue;
        contact.antagonist = b;
        add_contacts(contact, other, p, x, found_pairs[a]);
      }
      contact.n_nodes = 0;
      for (Index w = 0; w < room.n_walls(); ++w) {
        contact.slack = surface.boundary().slack(s, true) * surface.diameter();
        contact.gap = room.gap(w, x) + contact.slack;
        if (contact.gap > range.reach) continue;
        contact.antagonist = -1 - w;
        contact.normal = room.normal[w];
        found_walls[a].push_back(contact);
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
