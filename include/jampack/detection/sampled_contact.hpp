// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/detection/contact_discretisation.hpp>

namespace jampack {

/// The material point that a sample of a boundary is.
template <class Sample>
NodeWeights node_weights(const Sample& sample) {
  NodeWeights own;
  for (Index i = 0; i < sample.n; ++i) own.push_back({sample.node[std::size_t(i)], sample.weight[i]});
  return own;
}

/// Holds a contact's point, which is at x, above this tangent plane of the antagonist.
template <int Dim>
void hold(SurfaceContact<Dim>& contact, const GrainSurface<Dim>& surface,
          const typename GrainSurface<Dim>::TangentPlane& plane, const Vector<Dim>& x) {
  const auto& face = surface.boundary().faces[plane.face];
  const auto shape = face_shape<Dim>(face.n_nodes, plane.xi).value;
  contact.face = plane.face;
  contact.xi = plane.xi;
  contact.other.clear();
  for (Index i = 0; i < face.n_nodes; ++i) contact.other.push_back({face.node[std::size_t(i)], shape[i]});
  contact.normal = plane.normal;
  contact.gap = contact.normal.dot(x - weighted_point(contact.other, surface.position())) + contact.slack;
}

/// Contact at points: samples of either surface, each above the tangent plane of the face opposite. The nodes
/// of the grain that leads may not enter, all other samples a little (docs/theory/deformable_stage.md,
/// section 2).
struct SampledContact {
  template <int Dim>
  struct Place {
    const GrainSurface<Dim>* surface;
    Index sample;
    Vector<Dim> point;
    const typename Boundary<Dim>::Sample& of() const { return surface->boundary().samples[sample]; }
  };

  template <int Dim>
  Index n_points(const Boundary<Dim>& boundary, SampleSet set) const {
    return boundary.n_samples(set);
  }

  template <int Dim>
  Place<Dim> place(const GrainSurface<Dim>& surface, Index sample) const {
    return {&surface, sample, surface.sample_point(surface.boundary().samples[sample], surface.position())};
  }

  /// The walk to its projection starts from the nearest node.
  template <int Dim>
  void find(const Place<Dim>& place, const GrainSurface<Dim>& other, bool leads, const DetectionRange& range,
            SurfaceContact<Dim> contact, Array<SurfaceContact<Dim>>& found) const {
    const auto [node, distance] = other.nearest_node(place.point);
    const double edge = other.boundary().edge_length * other.diameter();
    if (std::sqrt(distance) > range.reach + range.depth + 2 * edge) return;
    if (other.is_above_all(place.point, node, range.reach)) return;
    const auto p = other.project(place.point, node);
    contact.slack = slack(place, leads);
    if (!p.on_surface || p.gap + contact.slack > range.reach || p.gap < -range.depth ||
        place.surface->sample_normal(place.of()).dot(p.normal) > 0.5)
      return;
    contact.own = node_weights(place.of());
    add_contacts(contact, other, p, place.point, found);
  }

  template <int Dim>
  bool renew(const Place<Dim>& place, const GrainSurface<Dim>& other, const SurfaceContact<Dim>& contact,
             Array<SurfaceContact<Dim>>& found) const {
    const auto p = other.project(place.point);
    if (p.on_surface) add_contacts(contact, other, p, place.point, found);
    return p.on_surface;
  }

  template <int Dim>
  void find_at_wall(const Place<Dim>& place, const Container<Dim>& room, const DetectionRange& range,
                    SurfaceContact<Dim> contact, Array<SurfaceContact<Dim>>& found) const {
    contact.slack = slack(place, true);
    contact.gap = room.gap(contact.wall(), place.point) + contact.slack;
    if (contact.gap > range.reach) return;
    contact.own = node_weights(place.of());
    contact.normal = room.normal[contact.wall()];
    found.push_back(contact);
  }

  /// A point at a plane stays what it is.
  template <int Dim>
  void renew_at_wall(const Place<Dim>&, const Container<Dim>&, SurfaceContact<Dim>&) const {}

 private:
  template <int Dim>
  static double slack(const Place<Dim>& place, bool leads) {
    return place.surface->boundary().slack(place.sample, leads) * place.surface->diameter();
  }

  /// The contacts of a sample at x, projected on the other grain, from one that knows all but its planes.
  template <int Dim>
  static void add_contacts(const SurfaceContact<Dim>& contact, const GrainSurface<Dim>& other,
                           const typename GrainSurface<Dim>::Projection& p, const Vector<Dim>& x,
                           Array<SurfaceContact<Dim>>& contacts) {
    constexpr double crease = 0.02;  // so near to one over the diameter, a sample may come to lie in it
    for (const auto& plane : other.tangent_planes(x, p, crease * other.diameter())) {
      contacts.push_back(contact);
      hold(contacts.back(), other, plane, x);
    }
  }
};

static_assert(ContactDiscretisation<SampledContact, 2> && ContactDiscretisation<SampledContact, 3>);

}  // namespace jampack
