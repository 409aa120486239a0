// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <jampack/detection/contact_discretisation.hpp>
#include <jampack/geometry/convex_piece.hpp>
#include <limits>

namespace jampack {

/// Contact on the mean: what may not be negative is the gap averaged over the dual cell of each boundary node
/// of the grain that leads (docs/theory/contact_discretisation.md). The cells tile its surface, and averages
/// are taken exactly over where a cell and the faces opposite overlap: a mortar method, whose forces are
/// pressures constant over cells, and which passes the patch test for any two meshes.
struct WeightedContact {
  template <int Dim>
  struct Place {
    const GrainSurface<Dim>* surface;
    Index node;  ///< number among the boundary nodes
    Vector<Dim> point;
  };

  template <int Dim>
  Index n_points(const Boundary<Dim>& boundary, SampleSet) const {
    return boundary.nodes.size();
  }

  template <int Dim>
  Place<Dim> place(const GrainSurface<Dim>& surface, Index node) const {
    return {&surface, node, surface.position().col(surface.boundary().nodes[node])};
  }

  template <int Dim>
  void find(const Place<Dim>& place, const GrainSurface<Dim>& other, bool leads, const DetectionRange& range,
            const SurfaceContact<Dim>& contact, Array<SurfaceContact<Dim>>& found) const {
    if (!leads) return;
    const double edge = other.boundary().edge_length * other.diameter();
    if (std::sqrt(other.nearest_node(place.point).second) > range.reach + range.depth + 2 * edge) return;
    if (!renew(place, other, contact, found)) return;
    if (found.back().gap > range.reach || found.back().gap < -range.depth) found.pop_back();
  }

  template <int Dim>
  bool renew(const Place<Dim>& place, const GrainSurface<Dim>& other, SurfaceContact<Dim> contact,
             Array<SurfaceContact<Dim>>& found) const {
    Mean<Dim> mean;
    double size = 0;
    const auto opposite = parts_near(other, place.point, farthest<Dim>(place) + most_apart(other));
    for_each_cell_piece(place, [&](const Part<Dim>& own, const ConvexPiece<Dim>& piece) {
      for (const Part<Dim>& part : opposite) add_overlap(own, piece, part, mean);
      integrate(piece, [&](const auto&, double measure) { size += own.stretch * measure; });
    });
    if (!(mean.size > 1e-3 * size)) return false;
    contact.normal = mean.normal.normalized();
    mean.write(contact, contact.normal.dot(mean.own_point - mean.other_point) / mean.size, [&] {
      return contact.normal.dot(weighted_point(contact.own, place.surface->position()) -
                                weighted_point(contact.other, other.position()));
    });
    found.push_back(contact);
    return true;
  }

  template <int Dim>
  void find_at_wall(const Place<Dim>& place, const Container<Dim>& room, const DetectionRange& range,
                    SurfaceContact<Dim> contact, Array<SurfaceContact<Dim>>& found) const {
    if (room.gap(contact.wall(), place.point) > range.reach + farthest<Dim>(place)) return;
    contact.gap = std::numeric_limits<double>::infinity();
    renew_at_wall(place, room, contact);
    if (contact.gap <= range.reach) found.push_back(contact);
  }

  template <int Dim>
  void renew_at_wall(const Place<Dim>& place, const Container<Dim>& room,
                     SurfaceContact<Dim>& contact) const {
    const Index wall = contact.wall();
    Mean<Dim> mean;
    for_each_cell_piece(place, [&](const Part<Dim>& own, const ConvexPiece<Dim>& piece) {
      const double share = facing(own.normal, room.normal[wall]);
      if (share == 0) return;
      integrate(piece, [&](const auto& at, double measure) {
        const double weight = share * own.stretch * measure;
        mean.size += weight;
        own.add(at, weight, mean.own, mean.own_point);
      });
    });
    if (mean.size == 0) return;
    contact.normal = room.normal[wall];
    mean.write(contact, room.gap(wall, mean.own_point / mean.size),
               [&] { return room.gap(wall, weighted_point(contact.own, place.surface->position())); });
  }

 private:
  /// A part of a surface where it is now: x = corner 0 + jacobian eta + height normal.
  template <int Dim>
  struct Part {
    using Eta = typename ConvexPiece<Dim>::Point;
    const GrainSurface<Dim>* surface;
    const SurfacePart<Dim>* of;
    std::array<Vector<Dim>, Dim> corner;
    Vector<Dim> normal;   ///< unit, outward
    Matrix<Dim> inverse;  ///< of (jacobian, normal): from x - corner 0 to (eta, height)
    double stretch;       ///< area (length in 2D) over measure in eta

    Part(const GrainSurface<Dim>& of_surface, Index p)
        : surface(&of_surface), of(&of_surface.boundary().parts.part[p]) {
      Eigen::Matrix<double, Dim, Dim - 1> tangent;
      for (std::size_t i = 0; i < Dim; ++i) corner[i] = surface->position().col(of->node[i]);
      for (std::size_t i = 1; i < Dim; ++i) tangent.col(Index(i) - 1) = corner[i] - corner[0];
      normal = face_normal<Dim>(tangent);
      stretch = normal.norm();
      normal /= stretch;
      Matrix<Dim> axes;
      axes << tangent, normal;
      inverse = axes.inverse();
    }

    /// Adds to `point` that of the face above eta, `weight` times, and to `weights` the shares of the nodes
    /// in the motion there.
    void add(const Eta& eta, double weight, NodeWeights& weights, Vector<Dim>& point) const {
      const auto& face = surface->boundary().faces[of->face];
      Eigen::Matrix<double, Dim, 1> share;
      share << 1 - eta.sum(), eta;
      FaceCoordinates<Dim> xi = FaceCoordinates<Dim>::Zero();
      for (std::size_t i = 0; i < Dim; ++i) xi += share[Index(i)] * face_node_coordinates<Dim>(of->local[i]);
      const auto shape = face_shape<Dim>(face.n_nodes, xi).value;
      const bool is_linear = surface->boundary().linear_on_parts;
      for (Index i = 0; i < face.n_nodes; ++i) {
        const Index node = face.node[std::size_t(i)];
        point += weight * shape[i] * surface->position().col(node);
        if (!is_linear) add(node, weight * shape[i], weights);
      }
      for (std::size_t i = 0; is_linear && i < Dim; ++i) add(of->node[i], weight * share[Index(i)], weights);
    }

   private:
    static void add(Index node, double weight, NodeWeights& weights) {
      auto* entry = std::find_if(weights.begin(), weights.end(),
                                 [&](const NodeWeight& known) { return known.node == node; });
      if (entry == weights.end())
        weights.push_back({node, weight});
      else
        entry->weight += weight;
    }
  };

  /// What a contact is the mean of: sums, until write().
  template <int Dim>
  struct Mean {
    double size = 0;
    NodeWeights own, other;
    Vector<Dim> own_point = Vector<Dim>::Zero(), other_point = Vector<Dim>::Zero();  ///< of the faces
    Vector<Dim> normal = Vector<Dim>::Zero();

    /// The gap between the faces is `gap`, that between the points that move as the weights say is left to
    /// the slack.
    template <class GapOfWeights>
    void write(SurfaceContact<Dim>& contact, double gap, GapOfWeights gap_of_weights) const {
      contact.own = own;
      contact.other = other;
      for (auto* weights : {&contact.own, &contact.other})
        for (auto& entry : *weights) entry.weight /= size;
      contact.gap = gap;
      contact.slack = gap - gap_of_weights();
    }
  };

  /// How much a surface with this outward normal counts as facing another with that one: what turns away is
  /// held by others, and the share goes from one to nothing smoothly.
  template <int Dim>
  static double facing(const Vector<Dim>& outward, const Vector<Dim>& against) {
    constexpr double all = -0.9, none = -0.6;  // cosines
    return std::clamp((none - outward.dot(against)) / (none - all), 0.0, 1.0);
  }

  /// Surfaces farther apart than this, on either side, do not face each other; length.
  template <int Dim>
  static double most_apart(const GrainSurface<Dim>& surface) {
    return 0.1 * surface.diameter();
  }

  /// Distance of the farthest corner of the parts about a node.
  template <int Dim>
  static double farthest(const Place<Dim>& place) {
    const auto& parts = place.surface->boundary().parts;
    double most = 0;
    for (const auto& [p, corner] : parts.of_node[place.node])
      for (const Index node : parts.part[p].node)
        most = std::max(most, (place.surface->position().col(node) - place.point).norm());
    return most;
  }

  /// Parts with a corner nearer to x than their own size and `distance`.
  template <int Dim>
  static Array<Part<Dim>> parts_near(const GrainSurface<Dim>& surface, const Vector<Dim>& x,
                                     double distance) {
    Array<Part<Dim>> near;
    const auto& parts = surface.boundary().parts.part;
    for (Index p = 0; p < parts.size(); ++p) {
      const Vector<Dim> first = surface.position().col(parts[p].node[0]);
      double size = 0;
      for (const Index node : parts[p].node)
        size = std::max(size, (surface.position().col(node) - first).squaredNorm());
      const double reach = distance + std::sqrt(size);
      if ((first - x).squaredNorm() < reach * reach) near.emplace_back(surface, p);
    }
    return near;
  }

  /// Calls visit(part, piece) for the pieces of a node's dual cell: in every part at the node, that third (in
  /// 2D that half) of it that is nearer to this corner, by barycentric coordinates, than to the others.
  template <int Dim, class Visit>
  static void for_each_cell_piece(const Place<Dim>& place, Visit visit) {
    for (const auto& [p, corner] : place.surface->boundary().parts.of_node[place.node]) {
      std::array<typename ConvexPiece<Dim>::Point, Dim> eta;
      for (std::size_t i = 0; i < Dim; ++i) eta[i].setZero();
      for (std::size_t i = 1; i < Dim; ++i) eta[i][Index(i) - 1] = 1;
      ConvexPiece<Dim> piece;
      const auto &a = eta[corner], &b = eta[(corner + 1) % Dim];
      piece.push_back(a);
      piece.push_back((a + b) / 2);
      if constexpr (Dim == 3) {
        const auto& c = eta[(corner + 2) % 3];
        piece.push_back((a + b + c) / 3);
        piece.push_back((a + c) / 2);
      }
      visit(Part<Dim>(*place.surface, p), piece);
    }
  }

  /// Adds what of a piece of a part and another part lie above each other, along the normal of the first.
  template <int Dim>
  static void add_overlap(const Part<Dim>& own, const ConvexPiece<Dim>& piece, const Part<Dim>& other,
                          Mean<Dim>& mean) {
    using Eta = typename ConvexPiece<Dim>::Point;
    const double share = facing(own.normal, other.normal);
    if (share == 0) return;
    std::array<Vector<Dim>, Dim> seen;  // the other's corners, as (eta, height) of this part
    for (std::size_t i = 0; i < Dim; ++i) seen[i] = own.inverse * (other.corner[i] - own.corner[0]);
    Eigen::Matrix<double, Dim - 1, Dim - 1> sides;
    for (std::size_t i = 1; i < Dim; ++i)
      sides.col(Index(i) - 1) = (seen[i] - seen[0]).template head<Dim - 1>();
    const Eigen::Matrix<double, Dim - 1, Dim - 1> to_other = sides.inverse();
    const auto on_other = [&](const Eta& eta) {
      return Eta(to_other * (eta - seen[0].template head<Dim - 1>()));
    };
    ConvexPiece<Dim> overlap = piece;
    for (Index k = 0; k < Dim - 1; ++k) cut(overlap, [&](const Eta& eta) { return on_other(eta)[k]; });
    cut(overlap, [&](const Eta& eta) { return 1 - on_other(eta).sum(); });
    if (overlap.n == 0) return;
    const Eta middle = on_other(overlap.corner[0]);
    double height = seen[0][Dim - 1];
    for (std::size_t i = 1; i < Dim; ++i) height += middle[Index(i) - 1] * (seen[i] - seen[0])[Dim - 1];
    if (std::abs(height) > most_apart(*own.surface)) return;
    integrate(overlap, [&](const Eta& eta, double measure) {
      const double weight = share * own.stretch * measure;
      mean.size += weight;
      mean.normal += weight * (other.normal - own.normal);
      own.add(eta, weight, mean.own, mean.own_point);
      other.add(on_other(eta), weight, mean.other, mean.other_point);
    });
  }
};

static_assert(ContactDiscretisation<WeightedContact, 2> && ContactDiscretisation<WeightedContact, 3>);

}  // namespace jampack
