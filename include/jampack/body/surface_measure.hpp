// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/mesh/boundary_surface.hpp>

namespace jampack {

/// Volume enclosed by a surface and its area (area and perimeter in 2D).
struct SurfaceMeasure {
  double volume = 0;
  double area = 0;
};

namespace detail {

/// Quadrature exact for the volume under a quadratic face: three Gauss points in 2D, the six-point rule of
/// degree 4 on the triangle in 3D (Dunavant, Int. J. Numer. Meth. Eng. 21, 1985). Weights sum to the
/// reference length or area.
template <int Dim>
Array<std::pair<FaceCoordinates<Dim>, double>> face_quadrature() {
  using Xi = FaceCoordinates<Dim>;
  if constexpr (Dim == 2) {
    const double s = std::sqrt(0.15);
    return {{Xi(0.5 - s), 5.0 / 18}, {Xi(0.5), 8.0 / 18}, {Xi(0.5 + s), 5.0 / 18}};
  } else {
    constexpr double a = 0.445948490915965, b = 0.091576213509771;
    constexpr double wa = 0.5 * 0.223381589678011, wb = 0.5 * 0.109951743655322;
    return {{Xi(a, a), wa}, {Xi(1 - 2 * a, a), wa}, {Xi(a, 1 - 2 * a), wa},
            {Xi(b, b), wb}, {Xi(1 - 2 * b, b), wb}, {Xi(b, 1 - 2 * b), wb}};
  }
}

}  // namespace detail

/// Measures the surface at nodal positions x (Dim x n_nodes): V = (1/Dim) int x . n dA.
template <int Dim, class Nodal>
SurfaceMeasure measure_surface(const Boundary<Dim>& boundary, const Nodal& x) {
  static const auto quadrature = detail::face_quadrature<Dim>();
  const Vector<Dim> origin = x.col(boundary.nodes[0]);  // near the grain: keeps the digits
  SurfaceMeasure measure;
  for (const auto& face : boundary.faces)
    for (const auto& [xi, weight] : quadrature) {
      const auto shape = face_shape<Dim>(face.n_nodes, xi);
      Vector<Dim> point = -origin;
      Eigen::Matrix<double, Dim, Dim - 1> tangent = Eigen::Matrix<double, Dim, Dim - 1>::Zero();
      for (Index i = 0; i < face.n_nodes; ++i) {
        point += shape.value[i] * x.col(face.node[std::size_t(i)]);
        tangent += x.col(face.node[std::size_t(i)]) * shape.derivative.row(i);
      }
      const Vector<Dim> normal = face_normal<Dim>(tangent);
      measure.volume += weight * point.dot(normal) / Dim;
      measure.area += weight * normal.norm();
    }
  return measure;
}

}  // namespace jampack
