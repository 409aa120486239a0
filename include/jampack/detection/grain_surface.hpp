// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <jampack/mesh/boundary_surface.hpp>

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

  /// Projects x along the normal field, walking from face to face from `start`. Where that leads nowhere or
  /// deep inside, as it does beside a ridge when the walk ends on its far side, walks start on the faces
  /// around too, and the solution of least |gap| is taken. The result says whether x lies above or below the
  /// surface there (`on_surface`).
  Projection project(const Vector<Dim>& x, Index start) const {
    constexpr double trusted_depth = 2e-3;  // over the diameter
    Projection best = walk(x, start);
    if (best.on_surface && best.gap > -trusted_depth * diameter_) return best;
    for (const Index face : faces_around(start)) {
      const Projection p = walk(x, face);
      if (p.on_surface && (!best.on_surface || std::abs(p.gap) < std::abs(best.gap))) best = p;
    }
    return best;
  }

 private:
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

  Projection walk(const Vector<Dim>& x, Index start) const {
    Projection p;
    p.face = start;
    p.xi.setConstant(1.0 / Dim);
    Index previous = -1;
    for (int step = 0; step < 24; ++step) {
      const auto leave = solve_on_face(x, p);
      if (leave < 0) {
        p.on_surface = true;
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
    finish(x, p);
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
