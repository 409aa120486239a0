// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <jampack/core/array.hpp>
#include <jampack/core/dimension.hpp>
#include <jampack/core/error.hpp>
#include <jampack/io/canvas.hpp>
#include <jampack/io/colour_map.hpp>
#include <jampack/io/coloured_surface.hpp>
#include <jampack/io/png.hpp>
#include <numeric>

namespace jampack {

namespace detail {

/// The normals at the corners of each triangle: averaged over the triangles that share the corner and turn
/// by less than some 50 degrees there, so that round surfaces look round and edges stay sharp.
inline Array<std::array<Vector<3>, 3>> corner_normals(const Array<ColouredSurface::Triangle>& triangles) {
  const Index n = triangles.size();
  Array<Vector<3>> face_normal(n, Vector<3>::Zero());  // as long as twice the area
  for (Index t = 0; t < n; ++t) {
    const auto& corner = triangles[t].corner;
    face_normal[t] = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
  }
  const auto place = [&](Index i) -> const Vector<3>& {
    return triangles[i / 3].corner[static_cast<std::size_t>(i % 3)];
  };
  Array<Index> order(3 * n);
  std::iota(order.begin(), order.end(), Index(0));
  const auto before = [&](Index i, Index j) {
    return std::lexicographical_compare(place(i).begin(), place(i).end(), place(j).begin(), place(j).end());
  };
  std::sort(order.begin(), order.end(), before);
  Array<std::array<Vector<3>, 3>> normals(n);
  for (Index begin = 0, end = 0; begin < order.size(); begin = end) {
    while (end < order.size() && !before(order[begin], order[end])) ++end;
    for (Index i = begin; i < end; ++i) {
      const Vector<3> own = face_normal[order[i] / 3].normalized();
      Vector<3> sum = Vector<3>::Zero();
      for (Index j = begin; j < end; ++j) {
        const Vector<3>& other = face_normal[order[j] / 3];
        if (own.dot(other) > 0.65 * other.norm()) sum += other;
      }
      normals[order[i] / 3][static_cast<std::size_t>(order[i] % 3)] = sum.norm() > 0 ? sum.normalized() : own;
    }
  }
  return normals;
}

}  // namespace detail

/// The picture of a surface on white, hidden parts hidden. Throws InvalidInput where there are no triangles,
/// a corner is not finite, or everything lies in one point.
inline Image render(const ColouredSurface& surface) {
  require(!surface.triangles.empty(), "picture: no triangles to draw");
  require(surface.width > 0 && surface.width <= 20000, "picture: the width must be from 1 to 20000 pixels");
  // Rows: right, up, towards the viewer.
  Matrix<3> view;
  view.row(2) = surface.towards_viewer.normalized();
  view.row(0) = surface.up.cross(surface.towards_viewer).normalized();
  view.row(1) = view.row(2).cross(view.row(0));
  require(view.isUnitary(1e-9), "picture: the direction of view must differ from up");

  Eigen::AlignedBox3d bounds;
  for (const auto& triangle : surface.triangles)
    for (const auto& corner : triangle.corner) {
      require(corner.allFinite(), "picture: a corner is not finite");
      bounds.extend(Vector<3>(view * corner));
    }
  for (const auto& line : surface.lines)
    for (const auto& point : line) bounds.extend(Vector<3>(view * point));
  const double margin = 0.03 * bounds.sizes().head<2>().maxCoeff();
  require(margin > 0, "picture: everything lies in one point");
  const double scale = static_cast<double>(surface.width) / (bounds.sizes()[0] + 2 * margin);
  const double height = scale * (bounds.sizes()[1] + 2 * margin);
  detail::Canvas canvas(surface.width, std::clamp<Index>(static_cast<Index>(height), 1, 4 * surface.width));

  const auto project = [&](const Vector<3>& point) {
    const Vector<3> p = view * point;
    const double fine = scale * static_cast<double>(detail::Canvas::fineness);
    return Vector<3>((p[0] - bounds.min()[0] + margin) * fine, (bounds.max()[1] + margin - p[1]) * fine,
                     p[2]);
  };
  const auto [lower, upper] = surface.value_range();
  const double range = upper > lower ? upper - lower : 1.0;
  const Vector<3> light = (view.transpose() * Vector<3>(-0.45, 0.6, 1.0)).normalized();
  const auto normals = detail::corner_normals(surface.triangles);
  for (Index t = 0; t < surface.triangles.size(); ++t) {
    const auto& triangle = surface.triangles[t];
    canvas.triangle({project(triangle.corner[0]), project(triangle.corner[1]), project(triangle.corner[2])},
                    [&, first = lower](const Vector<3>& w) -> Vector<3> {
                      const double value =
                          w[0] * triangle.value[0] + w[1] * triangle.value[1] + w[2] * triangle.value[2];
                      const Vector<3> colour = viridis((value - first) / range);
                      if (!surface.lit) return colour;
                      const auto& n = normals[t];
                      const double facing = (w[0] * n[0] + w[1] * n[1] + w[2] * n[2]).normalized().dot(light);
                      const double gloss = 0.18 * std::pow(std::max(facing, 0.0), 24);
                      return colour * (0.42 + 0.62 * std::max(facing, 0.0)) + Vector<3>::Constant(gloss);
                    });
  }
  const double size = bounds.sizes().norm();
  if (surface.lit) canvas.outline(0.01 * size);
  for (const auto& line : surface.lines)
    canvas.line(project(line[0]), project(line[1]), Vector<3>::Constant(0.15), 0.002 * size);
  return canvas.image();
}

}  // namespace jampack
