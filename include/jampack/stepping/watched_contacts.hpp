// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <jampack/body/soft_packing.hpp>
#include <jampack/detection/surface_detection.hpp>
#include <jampack/law/contact_law.hpp>

namespace jampack {

/// The contacts that a step of a deformable packing watches, with their forces: samples within reach of
/// another grain or a wall. Their frames stay as they are until they are asked for again
/// (docs/theory/deformable_stage.md, sections 2 and 5).
template <class Packing, ContactLaw Law>
class WatchedContacts {
 public:
  static constexpr int Dim = Packing::dimension;
  static constexpr int N = n_contact_unknowns<Law, Dim>;
  using Nodal = typename Packing::Nodal;

  SurfaceContacts<Dim, N> pairs;  ///< grain against grain
  SurfaceContacts<Dim, 1> walls;  ///< grain against wall

  /// A step begins: no sample is set aside any more.
  void begin_step() { jumps_.clear(); }

  /// Was a sample set aside in the last step? Then it may be deeper than the law allows.
  bool any_set_aside() const {
    return std::any_of(jumps_.begin(), jumps_.end(), [](const Jumps& j) { return j.count >= most_jumps; });
  }

  /// Detects anew at positions x all of these samples that are nearer than `reach` (length); forces stay with
  /// their contacts.
  void find(const Packing& packing, const Array<Nodal>& x, double reach, SampleSet samples, Threads threads) {
    update_surfaces(packing, x, threads);
    Array<SurfaceContact<Dim>> found_pairs, found_walls;
    detect(surfaces_, packing.room, DetectionRange{reach, 0.1 * packing.mean_diameter(), samples}, threads,
           found_pairs, found_walls);
    const auto held = pairs;
    replace_contacts(pairs, found_pairs);
    replace_contacts(walls, found_walls);
    detected_at_ = x;
    detected_ = samples;
    // What detection did not find is here because it carries a force.
    const auto less = [](const auto& p, const auto& q) { return p.key() < q.key(); };
    project(packing, x, threads, [&](const auto& contact) {
      return !std::binary_search(found_pairs.begin(), found_pairs.end(), contact, less);
    });
    set_aside(packing, x, held);
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
    const auto held = pairs;
    update_surfaces(packing, x, threads);
    project(packing, x, threads, [&](const auto& contact) { return held_gap(packing, contact, x) < near; });
    set_aside(packing, x, held);
  }

  /// Of a contact in a step that ends at x: gap along the normal, slip across it (eq. 5).
  Vector<Dim> displacement(const Packing& packing, const SurfaceContact<Dim>& contact,
                           const Array<Nodal>& x) const {
    const auto& sample = packing.model->boundary.samples[contact.sample];
    const auto& surface = surfaces_[contact.candidate];
    const Vector<Dim> point = surface.sample_point(sample, x[contact.candidate]);
    if (contact.is_wall()) return (packing.room.gap(contact.wall(), point) + contact.slack) * contact.normal;
    const Vector<Dim> apart = point - contact.antagonist_point(x[contact.antagonist]);
    const Vector<Dim> before = surface.sample_point(sample, packing.grains[contact.candidate].position) -
                               contact.antagonist_point(packing.grains[contact.antagonist].position);
    const Vector<Dim> relative = apart - before;
    const double gap = contact.normal.dot(apart) + contact.slack;
    return relative + (gap - contact.normal.dot(relative)) * contact.normal;
  }

  /// Adds the nodal forces of these reactions (forces on the candidates) to `nodal`.
  template <class Reactions>
  void scatter(const Packing& packing, const Reactions& of_pairs, const Array<ContactVector<1>>& of_walls,
               Array<Nodal>& nodal) const {
    scatter_set(packing, pairs, of_pairs, nodal);
    scatter_set(packing, walls, of_walls, nodal);
  }

 private:
  void update_surfaces(const Packing& packing, const Array<Nodal>& x, Threads threads) {
    surfaces_.resize(x.size());
    parallel_for(threads, x.size(), [&](Index g) {
      surfaces_[g].update(packing.model->boundary, x[g], packing.grains[g].diameter);
    });
  }

  Vector<Dim> sample_point(const Packing& packing, const SurfaceContact<Dim>& contact,
                           const Array<Nodal>& x) const {
    return surfaces_[contact.candidate].sample_point(packing.model->boundary.samples[contact.sample],
                                                     x[contact.candidate]);
  }

  /// The gap at x along the frame as it is.
  double held_gap(const Packing& packing, const SurfaceContact<Dim>& contact, const Array<Nodal>& x) const {
    const Vector<Dim> apart =
        sample_point(packing, contact, x) - contact.antagonist_point(x[contact.antagonist]);
    return contact.normal.dot(apart) + contact.slack;
  }

  /// Frames at x of those grain-grain contacts that are chosen; those at walls do not change.
  template <class Chosen>
  void project(const Packing& packing, const Array<Nodal>& x, Threads threads, Chosen chosen) {
    constexpr Index chunk = 64;
    parallel_for(threads, (pairs.size() + chunk - 1) / chunk, [&](Index k) {
      for (Index c = k * chunk; c < std::min(pairs.size(), (k + 1) * chunk); ++c) {
        auto& contact = pairs.contact[c];
        if (!chosen(contact)) continue;
        const auto& other = surfaces_[contact.antagonist];
        const auto p = other.project(sample_point(packing, contact, x));
        // A sample that is not opposite the other grain any more keeps the plane it was held at.
        if (p.on_surface)
          contact.set(other, p);
        else
          contact.gap = held_gap(packing, contact, x);
      }
    });
  }

  /// Sets samples aside whose gap goes on jumping up and down as frames are renewed, `held` being the
  /// contacts with the frames before: where a surface has folded, a sample is below one sheet of it and above
  /// another, and has no gap that is continuous.
  void set_aside(const Packing& packing, const Array<Nodal>& x, const SurfaceContacts<Dim, N>& held) {
    const double jump = 1e-3 * packing.mean_diameter();
    Index h = 0;
    for (const auto& contact : pairs.contact) {
      while (h < held.size() && held.contact[h].key() < contact.key()) ++h;
      if (h == held.size()) break;
      if (held.contact[h].key() != contact.key()) continue;
      const double before = held_gap(packing, held.contact[h], x);
      if (!(std::abs(contact.gap - before) > jump && std::min(contact.gap, before) < jump)) continue;
      const bool inward = contact.gap < before;
      auto known =
          std::find_if(jumps_.begin(), jumps_.end(), [&](const Jumps& j) { return j.key == contact.key(); });
      if (known == jumps_.end()) {
        jumps_.push_back({contact.key(), inward, 1});
      } else if (known->inward != inward) {
        known->inward = inward;
        ++known->count;
      }
    }
    if (!any_set_aside()) return;
    SurfaceContacts<Dim, N> kept;
    for (Index c = 0; c < pairs.size(); ++c) {
      const auto key = pairs.contact[c].key();
      if (std::any_of(jumps_.begin(), jumps_.end(),
                      [&](const Jumps& j) { return j.count >= most_jumps && j.key == key; }))
        continue;
      kept.contact.push_back(pairs.contact[c]);
      kept.reaction.push_back(pairs.reaction[c]);
    }
    pairs = std::move(kept);
  }

  template <class Reactions, int M>
  static void scatter_set(const Packing& packing, const SurfaceContacts<Dim, M>& set,
                          const Reactions& reaction, Array<Nodal>& nodal) {
    for (Index c = 0; c < set.size(); ++c) {
      if (reaction[c].isZero(0)) continue;
      const auto& contact = set.contact[c];
      const auto& sample = packing.model->boundary.samples[contact.sample];
      const Vector<Dim> force = set.force(c, reaction[c]);
      for (Index i = 0; i < sample.n; ++i)
        nodal[contact.candidate].col(sample.node[std::size_t(i)]) += sample.weight[i] * force;
      for (Index i = 0; i < contact.n_nodes; ++i)
        nodal[contact.antagonist].col(contact.node[std::size_t(i)]) -= contact.weight[i] * force;
    }
  }

  /// How often in this step the gap of a sample has jumped the other way than before.
  struct Jumps {
    decltype(SurfaceContact<Dim>().key()) key;
    bool inward;
    int count;
  };
  static constexpr int most_jumps = 4;

  Array<Jumps> jumps_;
  Array<GrainSurface<Dim>> surfaces_;
  Array<Nodal> detected_at_;
  SampleSet detected_ = SampleSet::all;
};

}  // namespace jampack
