// SPDX-License-Identifier: MIT
#pragma once

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

  /// Detects anew at positions x all of these samples that are nearer than `reach` (length); forces stay with
  /// their contacts.
  void find(const Packing& packing, const Array<Nodal>& x, double reach, SampleSet samples, Threads threads) {
    update_surfaces(packing, x, threads);
    Array<SurfaceContact<Dim>> found_pairs, found_walls;
    detect(surfaces_, packing.room, DetectionRange{reach, 0.1 * packing.mean_diameter(), samples}, threads,
           found_pairs, found_walls);
    replace_contacts(pairs, found_pairs);
    replace_contacts(walls, found_walls);
    detected_at_ = x;
    detected_ = samples;
    project(packing, x, threads);
  }

  /// New frames at x; new contacts too where a node has moved far since they were found, or only coarse
  /// samples were looked at.
  void refresh(const Packing& packing, const Array<Nodal>& x, double reach, Threads threads) {
    double moved = 0;
    for (Index g = 0; g < x.size(); ++g)
      moved = std::max(moved, (x[g] - detected_at_[g]).colwise().norm().maxCoeff());
    if (moved > 0.3 * reach || detected_ != SampleSet::all) {
      find(packing, x, reach, SampleSet::all, threads);
    } else {
      update_surfaces(packing, x, threads);
      project(packing, x, threads);
    }
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

  /// Frames of the grain-grain contacts at x; those at walls do not change.
  void project(const Packing& packing, const Array<Nodal>& x, Threads threads) {
    constexpr Index chunk = 64;
    const auto& samples = packing.model->boundary.samples;
    parallel_for(threads, (pairs.size() + chunk - 1) / chunk, [&](Index k) {
      for (Index c = k * chunk; c < std::min(pairs.size(), (k + 1) * chunk); ++c) {
        auto& contact = pairs.contact[c];
        const auto& other = surfaces_[contact.antagonist];
        const Vector<Dim> point =
            surfaces_[contact.candidate].sample_point(samples[contact.sample], x[contact.candidate]);
        const auto p = other.project(point);
        // A sample that is not opposite the other grain any more keeps the plane it was held at.
        if (p.on_surface)
          contact.set(other, p);
        else
          contact.gap =
              contact.normal.dot(point - contact.antagonist_point(x[contact.antagonist])) + contact.slack;
      }
    });
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

  Array<GrainSurface<Dim>> surfaces_;
  Array<Nodal> detected_at_;
  SampleSet detected_ = SampleSet::all;
};

}  // namespace jampack
