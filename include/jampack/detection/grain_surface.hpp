// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <jampack/core/inline_array.hpp>
#include <jampack/detection/face_patch.hpp>
#include <jampack/detection/surface_bounds.hpp>
#include <jampack/mesh/boundary_surface.hpp>
#include <limits>
#include <utility>

namespace jampack {

/// The current surface of one grain: nodal positions with averaged nodal normals, so that both the
/// surface and its normal field are continuous from face to face.
template <int Dim>
class GrainSurface {
 public:
  using Nodal = Eigen::Matrix<double, Dim, Eigen::Dynamic>;

  /// A point x written as surface point plus gap times normal.
  struct Projection {
    Index face = -1;
    FaceCoordinates<Dim> xi;
    Vector<Dim> normal;  ///< unit, interpolated from the nodal normals
    double gap = 0;      ///< signed distance along `normal`, negative inside the grain
    bool on_surface = false;
  };

  /// The plane that touches a face at a point of it.
  struct TangentPlane {
    Index face = -1;
    FaceCoordinates<Dim> xi;
    Vector<Dim> normal;  ///< unit, outward
  };

  /// Takes over new nodal positions of a grain of this undeformed diameter; `position` must outlive the
  /// surface.
  void update(const Boundary<Dim>& boundary, const Nodal& position, double diameter) {
    diameter_ = diameter;
    boundary_ = &boundary;
    position_ = &position;
    normal_.setZero(Dim, position.cols());
    patches_.resize(boundary.faces.size());
    for (Index f = 0; f < boundary.faces.size(); ++f) {
      const auto& face = boundary.faces[f];
      patches_[f].set_points(face, position);
      for (Index i = 0; i < face.n_nodes; ++i)
        normal_.col(face.node[std::size_t(i)]) += face_normal<Dim>(tangent(f, face_node_coordinates<Dim>(i)));
    }
    for (const Index i : boundary.nodes) normal_.col(i).normalize();
    for (Index f = 0; f < boundary.faces.size(); ++f) patches_[f].set_normals(boundary.faces[f], normal_);
    bounds_.update(boundary, position, normal_);
  }

  const Boundary<Dim>& boundary() const { return *boundary_; }
  const Nodal& position() const { return *position_; }
  double diameter() const { return diameter_; }  ///< of the undeformed grain

  Vector<Dim> point(Index face, const FaceCoordinates<Dim>& xi) const {
    return FacePatch<Dim>::point_of(patches_[face].value(xi));
  }

  Vector<Dim> sample_point(const typename Boundary<Dim>::Sample& sample, const Nodal& position) const {
    Vector<Dim> x = Vector<Dim>::Zero();
    for (Index i = 0; i < sample.n; ++i) x += sample.weight[i] * position.col(sample.node[std::size_t(i)]);
    return x;
  }

  Vector<Dim> sample_normal(const typename Boundary<Dim>::Sample& sample) const {
    return sample_point(sample, normal_).normalized();
  }

  /// Unit normal of the face itself, which is not that of the faces around where they meet at an angle.
  Vector<Dim> own_normal(Index face, const FaceCoordinates<Dim>& xi) const {
    return face_normal<Dim>(tangent(face, xi)).normalized();
  }

  /// The tangent planes that bound where a point at x, whose projection this is, may go: that of the face it
  /// is above and, where it is nearer than `near` (length) to a hollow crease, of the face beyond too. A face
  /// folded back on itself has no plane: there the interpolated normal serves.
  InlineArray<TangentPlane, Dim + 1> tangent_planes(const Vector<Dim>& x, const Projection& p,
                                                    double near) const {
    constexpr double folded = 0.5;  // cosine between the two normals
    constexpr double flat = 0.01;   // angle at a crease that is none
    const Vector<Dim> own = own_normal(p.face, p.xi), foot = point(p.face, p.xi);
    InlineArray<TangentPlane, Dim + 1> planes;
    planes.push_back({p.face, p.xi, own.dot(p.normal) > folded ? own : p.normal});
    for (std::size_t side = 0; side < Dim; ++side) {
      const Crease crease = nearest_on_side(p.face, p.xi, side);
      const Vector<Dim> at = point(crease.beyond, crease.there);
      if ((x - at).norm() > near) continue;
      const Vector<Dim> first = own_normal(p.face, crease.here);
      const Vector<Dim> second = own_normal(crease.beyond, crease.there);
      const double angle = (second - first).norm();
      const bool is_hollow = first.dot(tangent(crease.beyond, crease.there) * crease.onwards) > 0;
      if (angle < flat || !is_hollow || second.dot(p.normal) < folded) continue;
      // Where this face curves back below the plane, it is not the plane that bounds. On the crease itself
      // the difference would be round-off.
      const Vector<Dim> back = foot - at;
      const double length = back.norm();
      if (length > 1e-9 * diameter_ && second.dot(back) < 0.4 * angle * length) continue;
      planes.push_back({crease.beyond, crease.there, second});
    }
    return planes;
  }

  /// The boundary node closest to a point, and its squared distance.
  std::pair<Index, double> nearest_node(const Vector<Dim>& x) const { return bounds_.nearest_node(x); }

  /// Is x above the plane that touches the whole grain from outside, along the normal of this node, by more
  /// than `distance`? Then it has no projection with a smaller gap.
  bool is_above_all(const Vector<Dim>& x, Index node, double distance) const {
    constexpr double round_off = 2e-6;  // of what is called a projection
    return bounds_.height(x, node, normal_) >
           std::max(distance, known_side * diameter_) + round_off * diameter_;
  }

  /// Is x inside? Exact but for points as near to the surface as a fifth of a face's side leaves its chord.
  bool contains(const Vector<Dim>& x) const { return contains(x, nearest_node(x).first); }
  bool contains(const Vector<Dim>& x, Index nearest) const {
    return bounds_.height(x, nearest, normal_) <= 0 &&
           bounds_.contains(x, normal_.col(nearest), patches_, 1e-12 * diameter_);
  }

  /// Projects x along the normal field, walking from face to face from the nearest node. (3) of
  /// docs/theory/deformable_stage.md can have several solutions: where the one found cannot be trusted, walks
  /// start on the faces around too, and of the solutions on the side of the surface that x is on, or nearer
  /// than that side is known, that of least |gap| is taken. The result says whether there is one
  /// (`on_surface`).
  Projection project(const Vector<Dim>& x) const { return project(x, nearest_node(x).first); }
  Projection project(const Vector<Dim>& x, Index nearest) const {
    constexpr double trusted_depth = 2e-3, trusted_height = 8e-3;  // over the diameter
    const Index start = boundary_->face_of_node[nearest];
    Projection best = walk(x, start);
    const bool is_outside = normal_.col(nearest).dot(x - position_->col(nearest)) > 0;
    const double distance = (x - position_->col(nearest)).norm();
    if (best.on_surface && best.gap > -trusted_depth * diameter_ &&
        (is_outside ? best.gap <= 1.01 * distance : best.gap < trusted_height * diameter_))
      return best;
    const double side = contains(x, nearest) ? -1 : 1;
    const auto fits = [&](const Projection& p) {
      return p.on_surface && side * p.gap >= -known_side * diameter_;
    };
    for (const Index face : faces_around(start)) {
      if (face == start) continue;
      const Projection p = walk(x, face);
      if (fits(p) && (!fits(best) || std::abs(p.gap) < std::abs(best.gap))) best = p;
    }
    best.on_surface = fits(best);
    return best;
  }

 private:
  /// Nearer than this over the diameter, it is not sure on which side of the surface a point is.
  static constexpr double known_side = 3e-3;

  /// Where two faces meet.
  struct Crease {
    Index beyond;                  ///< the other face
    FaceCoordinates<Dim> here;     ///< coordinates on the face it is seen from
    FaceCoordinates<Dim> there;    ///< and on the other one
    FaceCoordinates<Dim> onwards;  ///< from there to the corner that is not on the crease
  };

  /// The point of a side of a face that lies straight across from the opposite corner through xi.
  Crease nearest_on_side(Index face, const FaceCoordinates<Dim>& xi, std::size_t side) const {
    const Index beyond = boundary_->neighbour[face][side];
    const auto &from = boundary_->faces[face].node, &to = boundary_->faces[beyond].node;
    auto here = barycentric(xi);
    here[side] = 0;
    double sum = 0;
    for (const double b : here) sum += b;
    std::array<double, Dim> there{};
    std::size_t opposite = Dim * (Dim - 1) / 2;  // less the corners on the crease
    for (std::size_t k = 0; k < Dim; ++k) {
      if (k == side) continue;
      here[k] = sum > 1e-9 ? here[k] / sum : 1.0 / (Dim - 1);
      const auto same = std::size_t(std::find(to.begin(), to.begin() + Dim, from[k]) - to.begin());
      there[same] = here[k];
      opposite -= same;
    }
    const auto coordinates = [](const std::array<double, Dim>& b) {
      return FaceCoordinates<Dim>(Eigen::Map<const FaceCoordinates<Dim>>(b.data() + 1));
    };
    return {beyond, coordinates(here), coordinates(there),
            face_node_coordinates<Dim>(Index(opposite)) - coordinates(there)};
  }

  Eigen::Matrix<double, Dim, Dim - 1> tangent(Index face, const FaceCoordinates<Dim>& xi) const {
    return patches_[face].tangent(xi);
  }

  /// The faces within two of this one.
  auto faces_around(Index face) const {
    InlineArray<Index, Dim == 2 ? 5 : 10> found;
    found.push_back(face);
    Index first = 0;
    for (int ring = 0; ring < 2; ++ring) {
      const Index last = found.size();
      for (; first < last; ++first)
        for (const Index next : boundary_->neighbour[found[first]])
          if (std::find(found.begin(), found.end(), next) == found.end()) found.push_back(next);
    }
    return found;
  }

  Projection walk(const Vector<Dim>& x, Index start) const {
    Projection p;
    p.face = start;
    p.xi.setConstant(1.0 / Dim);
    Index previous = -1;
    for (int step = 0; step < 24; ++step) {
      const auto leave = solve_on_face(x, p);
      if (leave < 0) {
        // Newton's method may have ended at no solution.
        p.on_surface = finish(x, p) < 1e-6 * diameter_;
        return p;
      }
      const Index next = boundary_->neighbour[p.face][std::size_t(leave)];
      if (next == previous) break;  // the point belongs to the side between them, or to none of them
      previous = p.face;
      p.face = next;
      p.xi.setConstant(1.0 / Dim);
    }
    clamp(p);
    const double beside = finish(x, p);
    p.on_surface = beside < 1e-6 * diameter_;
    return p;
  }

  static std::array<double, Dim> barycentric(const FaceCoordinates<Dim>& xi) {
    if constexpr (Dim == 2)
      return {1 - xi[0], xi[0]};
    else
      return {1 - xi[0] - xi[1], xi[0], xi[1]};
  }

  /// Newton on S(xi) + c m(xi) = x, m the normals as interpolated, whatever c; returns the side to leave by,
  /// -1 when the solution is inside.
  Index solve_on_face(const Vector<Dim>& x, Projection& p) const {
    constexpr double last = 1e-7;  // what is left after a step is its square
    const auto& patch = patches_[p.face];
    for (int iteration = 0; iteration < 12; ++iteration) {
      FaceCoordinates<Dim> dxi = newton_step(x, patch.jet(p.xi));
      const double largest = dxi.cwiseAbs().maxCoeff();
      if (!std::isfinite(largest)) break;
      if (largest > 0.5) dxi *= 0.5 / largest;
      p.xi += dxi;
      const auto b = barycentric(p.xi);
      const auto lowest = std::min_element(b.begin(), b.end());
      if (*lowest < -0.4) return lowest - b.begin();
      if (largest < last) break;
    }
    const auto b = barycentric(p.xi);
    const auto lowest = std::min_element(b.begin(), b.end());
    return *lowest < -1e-12 ? lowest - b.begin() : -1;
  }

  static FaceCoordinates<Dim> newton_step(const Vector<Dim>& x, const typename FacePatch<Dim>::Jet& at) {
    using Patch = FacePatch<Dim>;
    const Vector<Dim> apart = x - at.point(), m = at.normal();
    const double c = m.dot(apart) / m.squaredNorm();
    const auto slope = [&](std::size_t k) {
      return Vector<Dim>(Patch::point_of(at.slope[k]) + c * Patch::normal_of(at.slope[k]));
    };
    // By Cramer's rule: (slopes, m) (dxi, dc) = apart - c m, and all but dxi drops out.
    if constexpr (Dim == 2) {
      const Vector<2> across{m[1], -m[0]};
      return FaceCoordinates<2>(apart.dot(across) / slope(0).dot(across));
    } else {
      const Vector<3> first = slope(0), u = slope(1).cross(m), v = m.cross(first);
      return FaceCoordinates<3>(apart.dot(u), apart.dot(v)) / first.dot(u);
    }
  }

  static void clamp(Projection& p) {
    p.xi = p.xi.cwiseMax(0.0).cwiseMin(1.0);
    if constexpr (Dim == 3)
      if (const double sum = p.xi.sum(); sum > 1) p.xi /= sum;
  }

  /// Normal and gap at the face coordinates as they stand; how far x lies beside that normal.
  double finish(const Vector<Dim>& x, Projection& p) const {
    const auto at = patches_[p.face].value(p.xi);
    p.normal = FacePatch<Dim>::normal_of(at).normalized();
    const Vector<Dim> apart = x - FacePatch<Dim>::point_of(at);
    p.gap = p.normal.dot(apart);
    return (apart - p.gap * p.normal).norm();
  }

  const Boundary<Dim>* boundary_ = nullptr;
  const Nodal* position_ = nullptr;
  Nodal normal_;
  Array<FacePatch<Dim>> patches_;
  SurfaceBounds<Dim> bounds_;
  double diameter_ = 1;
};

}  // namespace jampack
