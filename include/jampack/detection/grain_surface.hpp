// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <jampack/geometry/solid_angle.hpp>
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
    for (const auto& face : boundary.faces)
      for (Index i = 0; i < face.n_nodes; ++i) {
        const auto shape = face_shape<Dim>(face.n_nodes, face_node_coordinates<Dim>(i));
        normal_.col(face.node[std::size_t(i)]) +=
            face_normal<Dim>(interpolate(face, shape.derivative, position));
      }
    for (const Index i : boundary.nodes) normal_.col(i).normalize();
  }

  const Boundary<Dim>& boundary() const { return *boundary_; }
  const Nodal& position() const { return *position_; }
  double diameter() const { return diameter_; }  ///< of the undeformed grain

  Vector<Dim> point(Index face, const FaceCoordinates<Dim>& xi) const {
    const auto& f = boundary_->faces[face];
    return interpolate(f, face_shape<Dim>(f.n_nodes, xi).value, *position_);
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
  Array<TangentPlane> tangent_planes(const Vector<Dim>& x, const Projection& p, double near) const {
    constexpr double folded = 0.5;  // cosine between the two normals
    constexpr double flat = 0.01;   // angle at a crease that is none
    const Vector<Dim> own = own_normal(p.face, p.xi), foot = point(p.face, p.xi);
    Array<TangentPlane> planes{{p.face, p.xi, own.dot(p.normal) > folded ? own : p.normal}};
    for (std::size_t side = 0; side < Dim; ++side) {
      const Crease crease = nearest_on_side(p.face, p.xi, side);
      const Vector<Dim> at = point(crease.beyond, crease.there);
      if ((x - at).norm() > near) continue;
      const Vector<Dim> first = own_normal(p.face, crease.here);
      const Vector<Dim> second = own_normal(crease.beyond, crease.there);
      const double angle = (second - first).norm();
      const bool is_hollow = first.dot(tangent(crease.beyond, crease.there) * crease.onwards) > 0;
      if (angle < flat || !is_hollow || second.dot(p.normal) < folded) continue;
      // Where this face curves back below the plane, it is not the plane that bounds.
      const Vector<Dim> back = foot - at;
      if (second.dot(back) < 0.4 * angle * back.norm()) continue;
      planes.push_back({crease.beyond, crease.there, second});
    }
    return planes;
  }

  /// The boundary node closest to a point, and its squared distance.
  std::pair<Index, double> nearest_node(const Vector<Dim>& x) const {
    std::pair<Index, double> best{-1, std::numeric_limits<double>::infinity()};
    for (const Index i : boundary_->nodes)
      if (const double d = (position_->col(i) - x).squaredNorm(); d < best.second) best = {i, d};
    return best;
  }

  /// Is x inside? Exact but for points as near to the surface as a fifth of a face's side leaves its chord.
  bool contains(const Vector<Dim>& x) const {
    constexpr Index fine = 5;
    // Beyond, a face seen as one piece does.
    const double near = 1.5 * boundary_->edge_length * diameter_;
    double winding = 0;
    for (Index f = 0; f < boundary_->faces.size(); ++f) {
      const auto& face = boundary_->faces[f];
      bool is_near = false;
      for (Index i = 0; i < face.n_nodes; ++i)
        is_near = is_near || (position_->col(face.node[std::size_t(i)]) - x).norm() < near;
      winding += winding_of_face(x, f, is_near ? fine : 1);
    }
    return winding > 0.5;
  }

  /// Projects x along the normal field, walking from face to face from the nearest node. (3) of
  /// docs/theory/deformable_stage.md can have several solutions: where the one found cannot be trusted, walks
  /// start on the faces around too, and of the solutions on the side of the surface that x is on, or nearer
  /// than that side is known, that of least |gap| is taken. The result says whether there is one
  /// (`on_surface`).
  Projection project(const Vector<Dim>& x) const { return project(x, nearest_node(x).first); }
  Projection project(const Vector<Dim>& x, Index nearest) const {
    constexpr double trusted_depth = 2e-3, trusted_height = 8e-3, known_side = 3e-3;  // over the diameter
    const Index start = boundary_->face_of_node[nearest];
    Projection best = walk(x, start);
    const bool is_outside = normal_.col(nearest).dot(x - position_->col(nearest)) > 0;
    const double distance = (x - position_->col(nearest)).norm();
    if (best.on_surface && best.gap > -trusted_depth * diameter_ &&
        (is_outside ? best.gap <= 1.01 * distance : best.gap < trusted_height * diameter_))
      return best;
    const double side = contains(x) ? -1 : 1;
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
    const auto& f = boundary_->faces[face];
    return interpolate(f, face_shape<Dim>(f.n_nodes, xi).derivative, *position_);
  }

  /// The faces within two of this one.
  Array<Index> faces_around(Index face) const {
    Array<Index> found{face};
    Index first = 0;
    for (int ring = 0; ring < 2; ++ring) {
      const Index last = found.size();
      for (; first < last; ++first)
        for (const Index next : boundary_->neighbour[found[first]])
          if (std::find(found.begin(), found.end(), next) == found.end()) found.push_back(next);
    }
    return found;
  }

  /// Of face f cut into n pieces a side, about x.
  double winding_of_face(const Vector<Dim>& x, Index f, Index n) const {
    const double side = 1 / double(n);
    double winding = 0;
    for (Index i = 0; i < n; ++i)
      if constexpr (Dim == 2) {
        const auto corner = [&](Index k) {
          return Vector<2>(point(f, FaceCoordinates<2>(side * double(k))) - x);
        };
        winding += solid_angle<2>({corner(i), corner(i + 1)});
      } else {
        const auto corner = [&](Index k, Index l) {
          return Vector<3>(point(f, side * FaceCoordinates<3>(double(k), double(l))) - x);
        };
        for (Index j = 0; i + j < n; ++j) {
          winding += solid_angle<3>({corner(i, j), corner(i + 1, j), corner(i, j + 1)});
          if (i + j + 1 < n)
            winding += solid_angle<3>({corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)});
        }
      }
    return winding;
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

  template <class Weights>
  static auto interpolate(const BoundaryFace<Dim>& face, const Weights& weight, const Nodal& field) {
    Eigen::Matrix<double, Dim, Weights::ColsAtCompileTime> sum;
    sum.setZero();
    for (Index i = 0; i < face.n_nodes; ++i) sum += field.col(face.node[std::size_t(i)]) * weight.row(i);
    return sum;
  }

  static std::array<double, Dim> barycentric(const FaceCoordinates<Dim>& xi) {
    if constexpr (Dim == 2)
      return {1 - xi[0], xi[0]};
    else
      return {1 - xi[0] - xi[1], xi[0], xi[1]};
  }

  /// Newton on S(xi) + g n(xi) = x; returns the side to leave by, -1 when the solution is inside.
  Index solve_on_face(const Vector<Dim>& x, Projection& p) const {
    const auto& face = boundary_->faces[p.face];
    for (int iteration = 0; iteration < 12; ++iteration) {
      const auto shape = face_shape<Dim>(face.n_nodes, p.xi);
      const Vector<Dim> s = interpolate(face, shape.value, *position_);
      const Vector<Dim> m = interpolate(face, shape.value, normal_);
      const double length = m.norm();
      p.normal = m / length;
      p.gap = p.normal.dot(x - s);
      Matrix<Dim> jacobian;
      const Eigen::Matrix<double, Dim, Dim - 1> dm = interpolate(face, shape.derivative, normal_);
      jacobian.template leftCols<Dim - 1>() = interpolate(face, shape.derivative, *position_) +
                                              p.gap / length * (dm - p.normal * (p.normal.transpose() * dm));
      jacobian.col(Dim - 1) = p.normal;
      const Vector<Dim> error = x - s - p.gap * p.normal;
      const Vector<Dim> step = jacobian.inverse() * error;
      if (!step.allFinite()) break;
      FaceCoordinates<Dim> dxi = step.template head<Dim - 1>();
      const double largest = dxi.cwiseAbs().maxCoeff();
      if (largest > 0.5) dxi *= 0.5 / largest;
      p.xi += dxi;
      p.gap += step[Dim - 1];
      const auto b = barycentric(p.xi);
      const auto lowest = std::min_element(b.begin(), b.end());
      if (*lowest < -0.4) return lowest - b.begin();
      if (largest < 1e-13) break;
    }
    const auto b = barycentric(p.xi);
    const auto lowest = std::min_element(b.begin(), b.end());
    return *lowest < -1e-12 ? lowest - b.begin() : -1;
  }

  static void clamp(Projection& p) {
    p.xi = p.xi.cwiseMax(0.0).cwiseMin(1.0);
    if constexpr (Dim == 3)
      if (const double sum = p.xi.sum(); sum > 1) p.xi /= sum;
  }

  /// Normal and gap at the face coordinates as they stand; how far x lies beside that normal.
  double finish(const Vector<Dim>& x, Projection& p) const {
    const auto& face = boundary_->faces[p.face];
    const auto shape = face_shape<Dim>(face.n_nodes, p.xi);
    p.normal = interpolate(face, shape.value, normal_).normalized();
    const Vector<Dim> apart = x - interpolate(face, shape.value, *position_);
    p.gap = p.normal.dot(apart);
    return (apart - p.gap * p.normal).norm();
  }

  const Boundary<Dim>* boundary_ = nullptr;
  const Nodal* position_ = nullptr;
  Nodal normal_;
  double diameter_ = 1;
};

}  // namespace jampack
