// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <jampack/core/array.hpp>
#include <jampack/core/dimension.hpp>
#include <limits>
#include <utility>

namespace jampack {

/// What a picture shows: triangles with a value at each corner, and lines such as the edges of a box or the
/// outlines of disks. In 2D everything lies at z = 0 and is seen from above, without light.
struct ColouredSurface {
  struct Triangle {
    std::array<Vector<3>, 3> corner;  ///< anticlockwise seen from outside
    std::array<double, 3> value;
  };
  using Line = std::array<Vector<3>, 2>;

  Array<Triangle> triangles;
  Array<Line> lines;
  Vector<3> towards_viewer = Vector<3>(0.55, -0.75, 0.42);  ///< any length; parallel projection
  Vector<3> up = Vector<3>::UnitZ();
  bool lit = true;
  Index width = 1200;  ///< pixels; the height follows
  /// Values of the first and last colour; NaN: the least and greatest value there is.
  double lower = std::numeric_limits<double>::quiet_NaN();
  double upper = std::numeric_limits<double>::quiet_NaN();

  /// As a packing of this dimension is usually looked at.
  template <int Dim>
  static ColouredSurface of_dimension() {
    ColouredSurface surface;
    if constexpr (Dim == 2) {
      surface.towards_viewer = Vector<3>::UnitZ();
      surface.up = Vector<3>::UnitY();
      surface.lit = false;
    }
    return surface;
  }

  template <int Dim>
  void add_triangle(const std::array<Vector<Dim>, 3>& corner, const std::array<double, 3>& value) {
    triangles.push_back(
        {{in_space<Dim>(corner[0]), in_space<Dim>(corner[1]), in_space<Dim>(corner[2])}, value});
  }
  template <int Dim>
  void add_line(const Vector<Dim>& from, const Vector<Dim>& to) {
    lines.push_back({in_space<Dim>(from), in_space<Dim>(to)});
  }
  /// The edges of a box along the axes.
  template <int Dim>
  void add_box(const Vector<Dim>& low, const Vector<Dim>& high) {
    for (int corner = 0; corner < (1 << Dim); ++corner)
      for (int axis = 0; axis < Dim; ++axis) {
        if ((corner >> axis & 1) != 0) continue;
        Vector<Dim> from = low;
        for (int other = 0; other < Dim; ++other)
          if ((corner >> other & 1) != 0) from[other] = high[other];
        Vector<Dim> to = from;
        to[axis] = high[axis];
        add_line<Dim>(from, to);
      }
  }

  std::pair<double, double> value_range() const {
    std::pair<double, double> range(std::numeric_limits<double>::infinity(),
                                    -std::numeric_limits<double>::infinity());
    for (const Triangle& triangle : triangles)
      for (const double value : triangle.value) {
        if (!std::isfinite(value)) continue;
        range.first = std::min(range.first, value);
        range.second = std::max(range.second, value);
      }
    if (!(range.first <= range.second)) range = {0, 1};
    if (!std::isnan(lower)) range.first = lower;
    if (!std::isnan(upper)) range.second = upper;
    return range;
  }

 private:
  template <int Dim>
  static Vector<3> in_space(const Vector<Dim>& point) {
    if constexpr (Dim == 2)
      return Vector<3>(point[0], point[1], 0.0);
    else
      return point;
  }
};

}  // namespace jampack
