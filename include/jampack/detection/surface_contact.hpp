// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <jampack/detection/grain_surface.hpp>
#include <jampack/geometry/container.hpp>
#include <jampack/law/friction_cone.hpp>
#include <tuple>

namespace jampack {

/// A node and its share in a point.
struct NodeWeight {
  Index node;
  double weight;
};
/// A point of a grain, or a mean of such points: the shares sum to one.
using NodeWeights = InlineArray<NodeWeight, 6>;

/// The point at nodal positions x; of other nodal fields the mean with the same shares.
template <class Nodal>
Vector<Nodal::RowsAtCompileTime> weighted_point(const NodeWeights& weights, const Nodal& x) {
  Vector<Nodal::RowsAtCompileTime> sum = Vector<Nodal::RowsAtCompileTime>::Zero();
  for (const auto& [node, weight] : weights) sum += weight * x.col(node);
  return sum;
}

/// A point of a candidate grain held on one side of an antagonist grain or of a wall: the contact of
/// docs/theory/deformable_stage.md, section 2. What point that is, a contact discretisation says
/// (detection/contact_discretisation.hpp). Its row of H is sum_i w_i v_i (candidate) minus sum_j N_j v_j
/// (antagonist), along `normal` and across it.
template <int Dim>
struct SurfaceContact {
  Index candidate = 0;                                     ///< grain
  Index sample = 0;                                        ///< which of the candidate's points
  Index antagonist = 0;                                    ///< grain, or -1 - wall
  Index face = -1;                                         ///< of the antagonist's boundary; -1 for none
  FaceCoordinates<Dim> xi = FaceCoordinates<Dim>::Zero();  ///< on that face
  NodeWeights own;                                         ///< the candidate's point
  NodeWeights other;                                       ///< that of the antagonist; none at a wall
  Vector<Dim> normal = Vector<Dim>::Zero();                ///< from antagonist to candidate
  double slack = 0;  ///< the boundary that is held lies so far inside of the points, length
  double gap = 0;    ///< of that boundary: signed distance plus slack

  bool is_wall() const { return antagonist < 0; }
  Index wall() const { return -1 - antagonist; }
  /// Shared by the contacts of one point with several faces of one grain, at a hollow crease.
  auto key() const { return std::tuple(candidate, sample, antagonist); }

  /// Calls spread(grain, node, weight) for all nodes that a force on the candidate acts on, the opposite one
  /// on the antagonist included.
  template <class Visit>
  void for_each_node(Visit spread) const {
    for (const auto& [node, weight] : own) spread(candidate, node, weight);
    for (const auto& [node, weight] : other) spread(antagonist, node, -weight);
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
