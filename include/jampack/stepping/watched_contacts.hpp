// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <jampack/body/soft_packing.hpp>
#include <jampack/detection/surface_detection.hpp>
#include <jampack/law/contact_law.hpp>
#include <limits>

namespace jampack {

/// The contacts that a step of a deformable packing watches, with their forces: those that a discretisation
/// finds within reach of another grain or a wall. Their frames stay as they are until they are asked for
/// again (docs/theory/deformable_stage.md, sections 2 and 5).
template <class Packing, ContactLaw Law, class Discretisation = SampledContact>
requires ContactDiscretisation<Discretisation, Packing::dimension>
class WatchedContacts {
 public:
  static constexpr int Dim = Packing::dimension;
  static constexpr int N = n_contact_unknowns<Law, Dim>;
  using Nodal = typename Packing::Nodal;

  Discretisation discretisation;
  SurfaceContacts<Dim, N> pairs;  ///< grain against grain
  SurfaceContacts<Dim, 1> walls;  ///< grain against wall

  /// Detects anew at positions x all of these samples that are nearer than `reach` (length); forces stay with
  /// their contacts.
  void find(const Packing& packing, const Array<Nodal>& x, double reach, SampleSet samples, Threads threads) {
    update_surfaces(packing, x, threads);
    Array<SurfaceContact<Dim>> found_pairs, found_walls;
    detect(discretisation, surfaces_, packing.room,
           DetectionRange{reach, 0.1 * packing.mean_diameter(), samples}, threads, found_pairs, found_walls);
    // What detection did not find and is kept carries a force.
    const auto kept = replace_contacts(pairs, std::move(found_pairs));
    replace_contacts(walls, std::move(found_walls));
    detected_at_ = x;
    detected_ = samples;
    project(x, threads, kept);
  }

  /// New frames at x for what may come to carry; new contacts too where a node has moved far since they were
  /// found, or only coarse samples were looked at.
  void refresh(const Packing& packing, const Array<Nodal>& x, double reach, Threads threads) {
    double moved = 0;
    for (Index g = 0; g < x.size(); ++g)
      moved = std::max(moved, (x[g] - detected_at_[g]).colwise().norm().maxCoeff());
    if (moved > 0.3 * reach || detected_ != SampleSet::all)
      return find(packing, x, reach, SampleSet::all, threads);
    const double near = 0.1 * reach;
    update_surfaces(packing, x, threads);
    Array<Index> chosen;
    for (Index c = 0; c < pairs.size(); c = end_of_sample(pairs.contact, c))
      if (least_gap(c, x) < near) chosen.push_back(c);
    project(x, threads, chosen);
    for (auto& contact : walls.contact)
      if (contact.gap < near)
        discretisation.renew_at_wall(discretisation.place(surfaces_[contact.candidate], contact.sample),
                                     packing.room, contact);
  }

  /// Of a contact in a step that ends at x: gap along the normal, slip across it (eq. 5).
  Vector<Dim> displacement(const Packing& packing, const SurfaceContact<Dim>& contact,
                           const Array<Nodal>& x) const {
    const Vector<Dim> point = weighted_point(contact.own, x[contact.candidate]);
    if (contact.is_wall()) return (packing.room.gap(contact.wall(), point) + contact.slack) * contact.normal;
    const Vector<Dim> apart = point - weighted_point(contact.other, x[contact.antagonist]);
    const Vector<Dim> before = weighted_point(contact.own, packing.grains[contact.candidate].position) -
                               weighted_point(contact.other, packing.grains[contact.antagonist].position);
    const Vector<Dim> relative = apart - before;
    const double gap = contact.normal.dot(apart) + contact.slack;
    return relative + (gap - contact.normal.dot(relative)) * contact.normal;
  }

  /// Adds the nodal forces of these reactions (forces on the candidates) to `nodal`.
  template <class Reactions>
  void scatter(const Reactions& of_pairs, const Array<ContactVector<1>>& of_walls,
               Array<Nodal>& nodal) const {
    scatter_set(pairs, of_pairs, nodal);
    scatter_set(walls, of_walls, nodal);
  }

 private:
  void update_surfaces(const Packing& packing, const Array<Nodal>& x, Threads threads) {
    surfaces_.resize(x.size());
    parallel_for(threads, x.size(), [&](Index g) {
      surfaces_[g].update(packing.model->boundary, x[g], packing.grains[g].diameter);
    });
  }

  /// The gap at x along the frame as it is.
  static double held_gap(const SurfaceContact<Dim>& contact, const Array<Nodal>& x) {
    const Vector<Dim> apart = weighted_point(contact.own, x[contact.candidate]) -
                              weighted_point(contact.other, x[contact.antagonist]);
    return contact.normal.dot(apart) + contact.slack;
  }

  /// The least of the gaps at x of the sample that contact c is the first of.
  double least_gap(Index c, const Array<Nodal>& x) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Index end = end_of_sample(pairs.contact, c); c < end; ++c)
      least = std::min(least, held_gap(pairs.contact[c], x));
    return least;
  }

  /// Frames at x of these samples between grains, given by their first contacts.
  void project(const Array<Nodal>& x, Threads threads, const Array<Index>& first) {
    constexpr Index chunk = 64;
    Array<Array<SurfaceContact<Dim>>> chunks((first.size() + chunk - 1) / chunk);
    parallel_for(threads, chunks.size(), [&](Index k) {
      for (Index s = k * chunk; s < std::min(first.size(), (k + 1) * chunk); ++s) {
        const Index c = first[s], end = end_of_sample(pairs.contact, c);
        const auto& contact = pairs.contact[c];
        const auto place = discretisation.place(surfaces_[contact.candidate], contact.sample);
        if (discretisation.renew(place, surfaces_[contact.antagonist], contact, chunks[k])) continue;
        // A point that is not opposite the other grain any more keeps the planes it was held at.
        for (Index i = c; i < end; ++i) pairs.contact[i].gap = held_gap(pairs.contact[i], x);
      }
    });
    Array<SurfaceContact<Dim>> all;
    for (auto& part : chunks)
      all.insert(all.end(), std::make_move_iterator(part.begin()), std::make_move_iterator(part.end()));
    if (!all.empty()) merge_contacts(pairs, std::move(all), [](Index, Index) { return true; });
  }

  template <class Reactions, int M>
  static void scatter_set(const SurfaceContacts<Dim, M>& set, const Reactions& reaction,
                          Array<Nodal>& nodal) {
    for (Index c = 0; c < set.size(); ++c) {
      if (reaction[c].isZero(0)) continue;
      const Vector<Dim> force = set.force(c, reaction[c]);
      set.contact[c].for_each_node(
          [&](Index grain, Index node, double weight) { nodal[grain].col(node) += weight * force; });
    }
  }

  Array<GrainSurface<Dim>> surfaces_;
  Array<Nodal> detected_at_;
  SampleSet detected_ = SampleSet::all;
};

}  // namespace jampack
