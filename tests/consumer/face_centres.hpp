// SPDX-License-Identifier: MIT
// A contact discretisation of one's own: all that jampack asks of it is in
// <jampack/detection/contact_discretisation.hpp>.
#pragma once

#include <jampack/detection/contact_discretisation.hpp>

/// The middle of every face of either grain may not enter the other one.
struct FaceCentres {
  struct Place {
    jampack::NodeWeights weights;
    jampack::Vector<3> point, outward;
  };

  jampack::Index n_points(const jampack::Boundary<3>& boundary, jampack::SampleSet) const {
    return boundary.faces.size();
  }

  Place place(const jampack::GrainSurface<3>& surface, jampack::Index face) const {
    return {weights(surface, face, middle), surface.point(face, middle), surface.own_normal(face, middle)};
  }

  void find(const Place& place, const jampack::GrainSurface<3>& other, bool /*leads*/,
            const jampack::DetectionRange& range, const jampack::SurfaceContact<3>& contact,
            jampack::Array<jampack::SurfaceContact<3>>& found) const {
    if (!renew(place, other, contact, found)) return;
    const auto& made = found.back();
    if (made.gap > range.reach || made.gap < -range.depth || place.outward.dot(made.normal) > 0)
      found.pop_back();
  }

  bool renew(const Place& place, const jampack::GrainSurface<3>& other, jampack::SurfaceContact<3> contact,
             jampack::Array<jampack::SurfaceContact<3>>& found) const {
    const auto opposite = other.project(place.point);
    if (!opposite.on_surface) return false;
    contact.own = place.weights;
    contact.other = weights(other, opposite.face, opposite.xi);
    contact.normal = opposite.normal;
    contact.gap = opposite.gap;
    found.push_back(contact);
    return true;
  }

  void find_at_wall(const Place& place, const jampack::Container<3>& room,
                    const jampack::DetectionRange& range, jampack::SurfaceContact<3> contact,
                    jampack::Array<jampack::SurfaceContact<3>>& found) const {
    contact.gap = room.gap(contact.wall(), place.point);
    if (contact.gap > range.reach) return;
    contact.own = place.weights;
    contact.normal = room.normal[contact.wall()];
    found.push_back(contact);
  }

  void renew_at_wall(const Place&, const jampack::Container<3>&, jampack::SurfaceContact<3>&) const {}

 private:
  inline static const jampack::FaceCoordinates<3> middle{1.0 / 3, 1.0 / 3};

  static jampack::NodeWeights weights(const jampack::GrainSurface<3>& surface, jampack::Index face,
                                      const jampack::FaceCoordinates<3>& xi) {
    const auto& nodes = surface.boundary().faces[face];
    const auto shape = jampack::face_shape<3>(nodes.n_nodes, xi).value;
    jampack::NodeWeights all;
    for (jampack::Index i = 0; i < nodes.n_nodes; ++i)
      all.push_back({nodes.node[static_cast<std::size_t>(i)], shape[i]});
    return all;
  }
};

static_assert(jampack::ContactDiscretisation<FaceCentres, 3>);
