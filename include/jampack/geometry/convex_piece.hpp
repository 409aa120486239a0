// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cassert>
#include <cmath>
#include <jampack/core/array.hpp>
#include <jampack/core/dimension.hpp>

namespace jampack {

/// A convex piece of a surface part in the coordinates of that part: the two ends of an interval (surfaces
/// in 2D), the corners of a polygon, counterclockwise (in 3D). No corners: nothing.
template <int Dim>
struct ConvexPiece {
  using Point = Eigen::Matrix<double, Dim - 1, 1>;
  /// Four corners of a dual cell and three cuts; as many again for corners that round-off makes of one.
  static constexpr std::size_t capacity = Dim == 2 ? 2 : 14;
  std::array<Point, capacity> corner;
  std::size_t n = 0;

  void push_back(const Point& point) {
    assert(n < capacity);
    corner[n++] = point;
  }
};

/// Leaves of a piece what lies where this affine function is not negative; every cut may add one corner.
template <int Dim, class Affine>
void cut(ConvexPiece<Dim>& piece, Affine height) {
  ConvexPiece<Dim> left;
  const auto crossing = [](const auto& a, double at_a, const auto& b, double at_b) {
    return typename ConvexPiece<Dim>::Point(a + at_a / (at_a - at_b) * (b - a));
  };
  for (std::size_t i = 0; i < piece.n; ++i) {
    const std::size_t next = (i + 1) % piece.n;
    const double here = height(piece.corner[i]), there = height(piece.corner[next]);
    if (here >= 0) left.push_back(piece.corner[i]);
    if constexpr (Dim == 2)
      if (next == 0) break;  // an interval has one side
    if ((here < 0) != (there < 0)) left.push_back(crossing(piece.corner[i], here, piece.corner[next], there));
  }
  piece = left;
}

/// Calls visit(point, measure) for the points of a quadrature of the piece: exact to degree 3 on intervals,
/// to degree 2 on polygons.
template <int Dim, class Visit>
void integrate(const ConvexPiece<Dim>& piece, Visit visit) {
  if constexpr (Dim == 2) {
    if (piece.n < 2) return;
    const auto span = piece.corner[1] - piece.corner[0];
    for (const double at : {0.5 - std::sqrt(1.0 / 12), 0.5 + std::sqrt(1.0 / 12)})
      visit(typename ConvexPiece<Dim>::Point(piece.corner[0] + at * span), 0.5 * std::abs(span[0]));
  } else {
    for (std::size_t i = 1; i + 1 < piece.n; ++i) {
      const std::array triangle{piece.corner[0], piece.corner[i], piece.corner[i + 1]};
      const Eigen::Vector2d a = triangle[1] - triangle[0], b = triangle[2] - triangle[0];
      const double area = (a[0] * b[1] - a[1] * b[0]) / 2;
      for (std::size_t q = 0; q < 3; ++q)
        visit(Eigen::Vector2d((triangle[0] + triangle[1] + triangle[2] + 3 * triangle[q]) / 6), area / 3);
    }
  }
}

}  // namespace jampack
