// SPDX-License-Identifier: MIT
#pragma once

#include <concepts>
#include <jampack/detection/surface_contact.hpp>

namespace jampack {

/// What separates contacts worth watching from the rest.
struct DetectionRange {
  double reach = 0;  ///< points nearer than this to another surface are kept, length
  double depth = 0;  ///< and none deeper than this: beyond it a point belongs to the other side, length
  SampleSet samples = SampleSet::all;
};

/// How non-penetration of two surfaces becomes contacts: which points of a grain (or means over pieces of its
/// surface) are held, and where on the other surface. Each has a number among those of its grain, fixed by
/// the reference mesh, and a Place: where it is now.
///
/// - n_points(boundary, set): how many there are.
/// - place(surface, i): where point i is; `.point` lies in its middle.
/// - find(place, other, leads, range, contact, found): adds to `found` the contacts of the point with another
///   grain that are in range. `contact` knows candidate, sample and antagonist; of two grains the candidate
///   leads, or the other one does.
/// - renew(place, other, contact, found): the same for a point whose contact is watched, in range or not.
///   False, with nothing added, where it is not opposite the other surface.
/// - find_at_wall(place, room, range, contact, found): contacts of the point with a wall.
/// - renew_at_wall(place, room, contact): brings such a contact up to date.
template <class D, int Dim>
concept ContactDiscretisation = requires(const D d, const Boundary<Dim> boundary,
                                         const GrainSurface<Dim> surface, const Container<Dim> room,
                                         const DetectionRange range, const SurfaceContact<Dim> contact,
                                         SurfaceContact<Dim> watched, Array<SurfaceContact<Dim>> found) {
  { d.n_points(boundary, SampleSet::all) } -> std::same_as<Index>;
  { d.place(surface, Index{}).point } -> std::convertible_to<Vector<Dim>>;
  { d.find(d.place(surface, Index{}), surface, true, range, contact, found) } -> std::same_as<void>;
  { d.renew(d.place(surface, Index{}), surface, contact, found) } -> std::same_as<bool>;
  { d.find_at_wall(d.place(surface, Index{}), room, range, contact, found) } -> std::same_as<void>;
  { d.renew_at_wall(d.place(surface, Index{}), room, watched) } -> std::same_as<void>;
};

}  // namespace jampack
