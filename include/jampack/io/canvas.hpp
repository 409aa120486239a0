// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <jampack/core/array.hpp>
#include <jampack/core/dimension.hpp>
#include <jampack/io/png.hpp>
#include <limits>
#include <utility>

namespace jampack::detail {

/// Colours with depth, drawn finer than the image and averaged at the end.
class Canvas {
 public:
  static constexpr Index fineness = 2;

  Canvas(Index width, Index height)
      : width_(fineness * width),
        height_(fineness * height),
        colour_(width_ * height_, Eigen::Vector3f::Ones()),
        depth_(width_ * height_, -std::numeric_limits<float>::infinity()) {}

  /// Draws where nothing nearer to the viewer (greater depth) is.
  void put(Index column, Index row, double depth, const Vector<3>& colour) {
    if (column < 0 || row < 0 || column >= width_ || row >= height_) return;
    const Index i = row * width_ + column;
    if (static_cast<float>(depth) < depth_[i]) return;
    depth_[i] = static_cast<float>(depth);
    colour_[i] = colour.cast<float>();
  }

  /// A triangle with corners (column, row, depth); colour(weights) gives the colour inside.
  template <class Colour>
  void triangle(const std::array<Vector<3>, 3>& p, Colour&& colour) {
    const auto cross = [](const Vector<3>& a, const Vector<3>& b, double x, double y) {
      return (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
    };
    const double area = cross(p[0], p[1], p[2][0], p[2][1]);
    if (area == 0 || !std::isfinite(area)) return;
    const auto [left, right] = std::minmax({p[0][0], p[1][0], p[2][0]});
    const auto [top, bottom] = std::minmax({p[0][1], p[1][1], p[2][1]});
    for (Index row = from(top); row <= to(bottom, height_); ++row)
      for (Index column = from(left); column <= to(right, width_); ++column) {
        const double x = static_cast<double>(column) + 0.5, y = static_cast<double>(row) + 0.5;
        const Vector<3> weight =
            Vector<3>(cross(p[1], p[2], x, y), cross(p[2], p[0], x, y), cross(p[0], p[1], x, y)) / area;
        if (weight.minCoeff() < 0) continue;
        put(column, row, weight[0] * p[0][2] + weight[1] * p[1][2] + weight[2] * p[2][2], colour(weight));
      }
  }

  void line(const Vector<3>& begin, const Vector<3>& end, const Vector<3>& colour, double nearer) {
    const double length = (end - begin).template head<2>().norm();
    if (!std::isfinite(length)) return;
    const auto n_steps = static_cast<Index>(2 * length) + 1;
    for (Index step = 0; step <= n_steps; ++step) {
      const Vector<3> p = begin + (end - begin) * static_cast<double>(step) / static_cast<double>(n_steps);
      for (Index i = 0; i < 9; ++i)
        put(static_cast<Index>(p[0]) + i % 3 - 1, static_cast<Index>(p[1]) + i / 3 - 1, p[2] + nearer,
            colour);
    }
  }

  /// Darkens where the depth jumps by more than this, which sets grains apart.
  void outline(double jump) {
    Array<Eigen::Vector3f> darkened = colour_;
    for (Index row = 1; row + 1 < height_; ++row)
      for (Index column = 1; column + 1 < width_; ++column) {
        const Index i = row * width_ + column;
        for (const Index neighbour : {i - 1, i + 1, i - width_, i + width_})
          if (depth_[neighbour] - depth_[i] > static_cast<float>(jump)) darkened[i] = 0.45F * colour_[i];
      }
    colour_ = darkened;
  }

  Image image() const {
    Image image{width_ / fineness, height_ / fineness, {}};
    image.pixels.reserve(image.width * image.height);
    for (Index row = 0; row < image.height; ++row)
      for (Index column = 0; column < image.width; ++column) {
        Eigen::Vector3f sum = Eigen::Vector3f::Zero();
        for (Index y = 0; y < fineness; ++y)
          for (Index x = 0; x < fineness; ++x)
            sum += colour_[(fineness * row + y) * width_ + fineness * column + x];
        sum = (sum * (255.0F / (fineness * fineness))).cwiseMax(0.0F).cwiseMin(255.0F);
        image.pixels.push_back({static_cast<std::uint8_t>(sum[0] + 0.5F),
                                static_cast<std::uint8_t>(sum[1] + 0.5F),
                                static_cast<std::uint8_t>(sum[2] + 0.5F)});
      }
    return image;
  }

 private:
  static Index from(double place) { return std::max<Index>(0, static_cast<Index>(std::max(place, 0.0))); }
  static Index to(double place, Index limit) {
    return static_cast<Index>(std::min(place, static_cast<double>(limit - 1)));
  }

  Index width_;
  Index height_;
  Array<Eigen::Vector3f> colour_;
  Array<float> depth_;
};

}  // namespace jampack::detail
