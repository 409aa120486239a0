// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <jampack/detection/grain_surface.hpp>
#include <jampack/geometry/container.hpp>
#include <jampack/law/friction_cone.hpp>
#include <tuple>

namespace jampack {

/// A surface sample of a candidate grain against the surface of an antagonist grain or against a wall: the
/// contact of docs/theory/deformable_stage.md, section 2. Its row of H is sum_i w_i v_i (candidate) minus
/// sum_j N_j(xi) v_j (antagonist), along `normal` and across it.
template <int Dim>
struct SurfaceContact {
  Index candidate = 0;                                     ///< grain
  Index sample = 0;                                        ///< of the candidate's boundary
  Index antagonist = 0;                                    ///< grain, or -1 - wall
  Index face = -1;                                         ///< of the antagonist's boundary
  FaceCoordinates<Dim> xi = FaceCoordinates<Dim>::Zero();  ///< on that face
  Index n_nodes = 0;                                       ///< of that face; 0 at a wall
  std::array<Index, max_face_nodes<Dim>> node{};
  Eigen::Matrix<double, max_face_nodes<Dim>, 1> weight =
      Eigen::Matrix<double, max_face_nodes<Dim>, 1>::Zero();
  Vector<Dim> normal = Vector<Dim>::Zero();  ///< from antagonist to candidate
  double slack = 0;  ///< how far the sample may enter, >= 0: its boundary lies that far inside, length
  double gap = 0;    ///< of that boundary: signed distance plus slack

  bool is_wall() const { return antagonist < 0; }
  Index wall() const { return -1 - antagonist; }
  /// Shared by the contacts of one sample with several faces of one grain, at a hollow crease.
  auto key() const { return std::tuple(candidate, sample, antagonist); }

  /// Holds the sample, which is at x, above this plane.
  void hold(const GrainSurface<Dim>& surface, const typename GrainSurface<Dim>::TangentPlane& plane,
            const Vector<Dim>& x) {
    const auto& f = surface.boundary().faces[plane.face];
    face = plane.face;
    xi = plane.xi;
    n_nodes = f.n_nodes;
    node = f.node;
    weight = face_shape<Dim>(f.n_nodes, xi).value;
    normal = plane.normal;
    gap = normal.dot(x - antagonist_point(surface.position())) + slack;
  }

  template <class Nodal>
  Vector<Dim> antagonist_point(const Nodal& x) const {
    Vector<Dim> sum = Vector<Dim>::Zero();
    for (Index i = 0; i < n_nodes; ++i) sum += weight[i] * x.col(node[std::size_t(i)]);
    return sum;
  }
};

/// Contacts that carry N unknowns each, sorted by key(); of those that share one, that with the face the
/// sample is above comes first. A reaction with one unknown is the normal force; with Dim unknowns it is the
/// force on the candidate in global axes, so that it stays meaningful while the normal turns.
template <int Dim, int N>
struct SurfaceContacts {
  Array<SurfaceContact<Dim>> contact;
  Array<ContactVector<N>> reaction;  ///< force

  Index size() const { return contact.size(); }

  Vector<Dim> force(Index c) const { return force(c, reaction[c]); }
  Vector<Dim> force(Index c, const ContactVector<N>& r) const {
    if constexpr (N == 1)
      return r[0] * contact[c].normal;
    else
      return r;
  }
};

}  // namespace jampack
