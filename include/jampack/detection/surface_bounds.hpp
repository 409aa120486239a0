// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <jampack/detection/face_patch.hpp>
#include <jampack/geometry/point_cloud.hpp>
#include <jampack/geometry/ray_crossings.hpp>
#include <jampack/geometry/solid_angle.hpp>
#include <jampack/mesh/boundary_surface.hpp>
#include <utility>

namespace jampack {

/// What says cheaply where a point is with respect to the surface of a grain.
///
/// A face lies within the convex hull of its corners and, for each mid node, that point which with the ends
/// of the side spans the parabola: from these come planes that touch the grain from outside, one for the
/// normal of each node, and balls about the faces.
template <int Dim>
class SurfaceBounds {
 public:
  /// `position` and `normal` (unit, outward) by mesh node.
  template <class Nodal>
  void update(const Boundary<Dim>& boundary, const Nodal& position, const Nodal& normal) {
    nodes_ = &boundary.nodes;
    Nodal control = position;
    for (const auto& face : boundary.faces)
      for (Index i = Dim; i < face.n_nodes; ++i) {
        const auto corner = [&](Index k) { return position.col(face.node[std::size_t(k % Dim)]); };
        const Index mid = face.node[std::size_t(i)];
        control.col(mid) = 2 * position.col(mid) - 0.5 * (corner(i - Dim) + corner(i - Dim + 1));
      }
    balls_.clear();
    for (const auto& face : boundary.faces) {
      auto& [centre, radius] = balls_.emplace_back(Ball{Vector<Dim>::Zero(), 0});
      for (Index i = 0; i < face.n_nodes; ++i)
        centre += control.col(face.node[std::size_t(i)]) / double(face.n_nodes);
      for (Index i = 0; i < face.n_nodes; ++i)
        radius = std::max(radius, (control.col(face.node[std::size_t(i)]) - centre).norm());
    }
    PointCloud<Dim> hull;
    cloud_.assign(nodes_->size());
    hull.assign(nodes_->size());
    for (Index i = 0; i < nodes_->size(); ++i) {
      cloud_.set(i, position.col((*nodes_)[i]));
      hull.set(i, control.col((*nodes_)[i]));
    }
    reach_.resize(position.cols());
    for (const Index i : *nodes_) reach_[i] = hull.reach(normal.col(i));
  }

  /// The boundary node closest to a point, and its squared distance.
  std::pair<Index, double> nearest_node(const Vector<Dim>& x) const {
    const auto [i, distance] = cloud_.nearest(x);
    return {(*nodes_)[i], distance};
  }

  /// Of x above the plane that touches the grain from outside across the normal of this node.
  template <class Nodal>
  double height(const Vector<Dim>& x, Index node, const Nodal& normal) const {
    return normal.col(node).dot(x) - reach_[node];
  }

  /// Is x inside, the shortest way out being about in the direction `out`? Faces are seen as small flat
  /// pieces; `round_off` is a length.
  bool contains(const Vector<Dim>& x, Vector<Dim> out, const Array<FacePatch<Dim>>& patches,
                double round_off) const {
    // Aslant, as points may lie straight below corners.
    for (int a = 0; a < Dim; ++a) out[a] += 0.05 / (1 + a);
    RayCrossings<Dim> ray(x, out.normalized(), round_off);
    for (Index f = 0; f < patches.size(); ++f)
      if (ray.may_hit(balls_[f].centre, balls_[f].radius))
        patches[f].for_each_piece([&](const auto& p) { return ray.seen(p); },
                                  [&](const auto& corners) { ray.add(corners); });
    if (ray.is_certain()) return ray.count() > 0;
    double winding = 0;
    for (const auto& patch : patches)
      patch.for_each_piece([&](const auto& p) { return Vector<Dim>(p - x); },
                           [&](const auto& corners) { winding += solid_angle<Dim>(corners); });
    return winding > 0.5;
  }

 private:
  struct Ball {
    Vector<Dim> centre;
    double radius;
  };

  const Array<Index>* nodes_ = nullptr;
  PointCloud<Dim> cloud_;  ///< the boundary nodes
  Array<double> reach_;    ///< of a boundary node: of the whole grain along the normal there
  Array<Ball> balls_;      ///< that hold the faces
};

}  // namespace jampack
