// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <jampack/core/array.hpp>
#include <jampack/core/dimension.hpp>

namespace jampack {

/// Largest number of nodes of a boundary face: 3-node edges in 2D, 6-node triangles in 3D.
template <int Dim>
inline constexpr int max_face_nodes = Dim == 2 ? 3 : 6;

/// Coordinates on a face. 2D: t in [0, 1] from corner 0 to corner 1. 3D: (L1, L2) of the barycentric
/// coordinates, L0 = 1 - L1 - L2.
template <int Dim>
using FaceCoordinates = Eigen::Matrix<double, Dim - 1, 1>;

/// Values of the nodal shape functions at a point of a face and their derivatives with respect to the face
/// coordinates; rows past the face's own node count are zero.
template <int Dim>
struct FaceShape {
  Eigen::Matrix<double, max_face_nodes<Dim>, 1> value;
  Eigen::Matrix<double, max_face_nodes<Dim>, Dim - 1> derivative;
};

/// Linear (n_nodes = Dim) or quadratic (3 | 6 nodes: corners, then mids 01, 12, 20) Lagrange functions.
template <int Dim>
FaceShape<Dim> face_shape(Index n_nodes, const FaceCoordinates<Dim>& xi) {
  FaceShape<Dim> s;
  s.value.setZero();
  s.derivative.setZero();
  const auto put = [&s](int i, double value, const auto&... derivative) {
    s.value[i] = value;
    int k = 0;
    ((s.derivative(i, k++) = derivative), ...);
  };
  if constexpr (Dim == 2) {
    const double t = xi[0];
    if (n_nodes == 2) {
      put(0, 1 - t, -1.0);
      put(1, t, 1.0);
    } else {
      put(0, (1 - t) * (1 - 2 * t), 4 * t - 3);
      put(1, t * (2 * t - 1), 4 * t - 1);
      put(2, 4 * t * (1 - t), 4 - 8 * t);
    }
  } else {
    const double a = 1 - xi[0] - xi[1], b = xi[0], c = xi[1];
    if (n_nodes == 3) {
      put(0, a, -1.0, -1.0);
      put(1, b, 1.0, 0.0);
      put(2, c, 0.0, 1.0);
    } else {
      put(0, a * (2 * a - 1), 1 - 4 * a, 1 - 4 * a);
      put(1, b * (2 * b - 1), 4 * b - 1, 0.0);
      put(2, c * (2 * c - 1), 0.0, 4 * c - 1);
      put(3, 4 * a * b, 4 * (a - b), -4 * b);
      put(4, 4 * b * c, 4 * c, 4 * b);
      put(5, 4 * c * a, -4 * c, 4 * (a - c));
    }
  }
  return s;
}

/// Coordinates of the local node i of a face.
template <int Dim>
FaceCoordinates<Dim> face_node_coordinates(Index i) {
  if constexpr (Dim == 2) {
    constexpr double t[] = {0, 1, 0.5};
    return FaceCoordinates<2>(t[i]);
  } else {
    constexpr double b[] = {0, 1, 0, 0.5, 0.5, 0}, c[] = {0, 0, 1, 0, 0.5, 0.5};
    return {b[i], c[i]};
  }
}

/// Outward area-weighted normal of a face from its tangents dx/dxi (columns); in 2D the interior lies to
/// the left of the edge.
template <int Dim>
Vector<Dim> face_normal(const Eigen::Matrix<double, Dim, Dim - 1>& tangent) {
  if constexpr (Dim == 2)
    return {tangent(1, 0), -tangent(0, 0)};
  else
    return tangent.col(0).cross(tangent.col(1));
}

}  // namespace jampack
