// SPDX-License-Identifier: MIT
#pragma once

#include <boost/geometry.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <iterator>

#include <jampack/core/parallel.hpp>
#include <jampack/detection/surface_contact.hpp>

namespace jampack {

/// What separates contacts worth watching from the rest.
struct DetectionRange {
  double reach = 0;  ///< samples nearer than this to another surface are kept, length
  double depth = 0;  ///< and none deeper than this: beyond it a sample belongs to the other side, length
};

namespace detail {

template <int Dim>
using RtreePoint = boost::geometry::model::point<double, std::size_t(Dim), boost::geometry::cs::cartesian>;
template <int Dim>
using RtreeBox = boost::geometry::model::box<RtreePoint<Dim>>;

template <int Dim>
RtreePoint<Dim> rtree_point(const Vector<Dim>& x) {
  if constexpr (Dim == 2)
    return {x[0], x[1]};
  else
    return {x[0], x[1], x[2]};
}

template <int Dim>
using NodeTree = boost::geometry::index::rtree<std::pair<RtreePoint<Dim>, Index>, boost::geometry::index::linear<8>>;

}  // namespace detail

/// All samples within range of another grain (`pairs`) or of a wall (`walls`), found with R-trees over the
/// grains' boxes and over each grain's boundary nodes; results are sorted by key.
template <int Dim>
void detect(const Array<GrainSurface<Dim>>& surfaces, const Container<Dim>& room, const DetectionRange& range,
            Threads threads, Array<SurfaceContact<Dim>>& pairs, Array<SurfaceContact<Dim>>& walls) {
  namespace bgi = boost::geometry::index;
  const Index n = surfaces.size();
  Array<Vector<Dim>> lower(n), upper(n);
  Array<detail::NodeTree<Dim>> nodes(n);
  parallel_for(threads, n, [&](Index g) {
    const auto& x = surfaces[g].position();
    lower[g].setConstant(std::numeric_limits<double>::infinity());
    upper[g] = -lower[g];
    Array<std::pair<detail::RtreePoint<Dim>, Index>> points;
    for (const Index i : surfaces[g].boundary().nodes) {
      lower[g] = lower[g].cwiseMin(x.col(i));
      upper[g] = upper[g].cwiseMax(x.col(i));
      points.emplace_back(detail::rtree_point<Dim>(x.col(i)), i);
    }
    nodes[g] = detail::NodeTree<Dim>(points.begin(), points.end());
  });
  // A quadratic face bulges past its nodes by less than a tenth of an edge: the boxes get that slack.
  const double slack = range.reach + range.depth;
  using Entry = std::pair<detail::RtreeBox<Dim>, Index>;
  Array<Entry> boxes;
  for (Index g = 0; g < n; ++g)
    boxes.emplace_back(
        detail::RtreeBox<Dim>(detail::rtree_point<Dim>(lower[g]), detail::rtree_point<Dim>(upper[g])), g);
  const bgi::rtree<Entry, bgi::linear<8>> grains(boxes.begin(), boxes.end());

  Array<Array<SurfaceContact<Dim>>> found_pairs(n), found_walls(n);
  parallel_for(threads, n, [&](Index a) {
    const auto& surface = surfaces[a];
    const Vector<Dim> margin = Vector<Dim>::Constant(slack);
    Array<Entry> near;
    grains.query(bgi::intersects(detail::RtreeBox<Dim>(detail::rtree_point<Dim>(lower[a] - margin),
                                                       detail::rtree_point<Dim>(upper[a] + margin))),
                 std::back_inserter(near));
    Array<Index> antagonists;
    for (const auto& entry : near)
      if (entry.second != a) antagonists.push_back(entry.second);
    std::sort(antagonists.begin(), antagonists.end());

    const auto& samples = surface.boundary().samples;
    for (Index s = 0; s < samples.size(); ++s) {
      const Vector<Dim> x = surface.sample_point(samples[s], surface.position());
      const Vector<Dim> outward = surface.sample_normal(samples[s]);
      SurfaceContact<Dim> contact;
      contact.candidate = a;
      contact.sample = s;
      for (const Index b : antagonists) {
        if ((x.array() < lower[b].array() - slack).any() || (x.array() > upper[b].array() + slack).any())
          continue;
        std::pair<detail::RtreePoint<Dim>, Index> closest;
        nodes[b].query(bgi::nearest(detail::rtree_point<Dim>(x), 1), &closest);
        const auto& other = surfaces[b];
        const auto p = other.project(x, other.boundary().face_of_node[closest.second]);
        if (!p.on_surface || p.gap > range.reach || p.gap < -range.depth || outward.dot(p.normal) > 0.5)
          continue;
        contact.antagonist = b;
        contact.set(other.boundary(), p);
        found_pairs[a].push_back(contact);
      }
      contact.n_nodes = 0;
      for (Index w = 0; w < room.n_walls(); ++w) {
        contact.gap = room.gap(w, x);
        if (contact.gap > range.reach) continue;
        contact.antagonist = -1 - w;
        contact.normal = room.normal[w];
        found_walls[a].push_back(contact);
      }
    }
  });
  pairs.clear();
  walls.clear();
  for (Index a = 0; a < n; ++a) {
    pairs.insert(pairs.end(), found_pairs[a].begin(), found_pairs[a].end());
    walls.insert(walls.end(), found_walls[a].begin(), found_walls[a].end());
  }
}

/// Replaces the contacts of a set, keeping the reactions of those that stay (both lists sorted by key).
/// A contact that goes while it carries a force is kept too: only the solver may release it.
template <int Dim, int N>
void replace_contacts(SurfaceContacts<Dim, N>& set, const Array<SurfaceContact<Dim>>& fresh) {
  SurfaceContacts<Dim, N> merged;
  Index old = 0;
  auto keep_loaded = [&] {
    if (!set.reaction[old].isZero(0)) {
      merged.contact.push_back(set.contact[old]);
      merged.reaction.push_back(set.reaction[old]);
    }
    ++old;
  };
  for (const auto& contact : fresh) {
    while (old < set.size() && set.contact[old].key() < contact.key()) keep_loaded();
    merged.contact.push_back(contact);
    if (old < set.size() && set.contact[old].key() == contact.key())
      merged.reaction.push_back(set.reaction[old++]);
    else
      merged.reaction.push_back(ContactVector<N>::Zero());
  }
  while (old < set.size()) keep_loaded();
  set = std::move(merged);
}

}  // namespace jampack
