// SPDX-License-Identifier: MIT
#pragma once

// Boost's own headers include ones that Boost has deprecated, and say so at every compilation.
#ifndef BOOST_ALLOW_DEPRECATED_HEADERS
#define BOOST_ALLOW_DEPRECATED_HEADERS
#define JAMPACK_BOOST_QUIETENED
#endif
#include <boost/geometry/geometries/box.hpp>
#include <boost/geometry/geometries/point.hpp>
#include <boost/geometry/index/rtree.hpp>
#ifdef JAMPACK_BOOST_QUIETENED
#undef BOOST_ALLOW_DEPRECATED_HEADERS
#undef JAMPACK_BOOST_QUIETENED
#endif

#include <algorithm>
#include <cmath>
#include <iterator>
#include <jampack/core/error.hpp>
#include <jampack/detection/broad_phase.hpp>
#include <string>
#include <utility>
#include <vector>

namespace jampack {

/// Broad phase by a Boost.Geometry R-tree over the balls' boxes, with a skin: pairs are listed out to
/// reach + skin, and the list is kept until some ball has moved or grown so far that a pair beyond it might
/// have come within reach (twice the largest displacement plus growth of a radius exceeds the skin).
template <int Dim>
class RTree {
 public:
  /// `skin` in mean diameters, >= 0; larger: fewer rebuilds, longer lists.
  explicit RTree(double skin = 0.3) : skin_(skin) {
    require(std::isfinite(skin) && skin >= 0,
            "R-tree: the skin must be finite and not negative, got " + std::to_string(skin));
  }

  /// All pairs whose surfaces are at most `reach` (length) apart, and some up to reach + skin.
  const Array<BallPair>& pairs(const Balls<Dim>& balls, double reach) {
    if (!still_valid(balls, reach)) rebuild(balls, reach);
    return pairs_;
  }

  Index n_rebuilds() const { return n_rebuilds_; }

 private:
  using Point = boost::geometry::model::point<double, Dim, boost::geometry::cs::cartesian>;
  using Extent = boost::geometry::model::box<Point>;
  using Entry = std::pair<Extent, Index>;

  bool still_valid(const Balls<Dim>& balls, double reach) const {
    if (n_rebuilds_ == 0 || balls.size() != built_from_.size()) return false;
    double moved = 0.0;
    for (Index i = 0; i < balls.size(); ++i)
      moved = std::max(moved, (balls.position[i] - built_from_.position[i]).norm() +
                                  0.5 * (balls.diameter[i] - built_from_.diameter[i]));
    return reach + 2.0 * moved <= listed_to_;
  }

  void rebuild(const Balls<Dim>& balls, double reach) {
    listed_to_ = reach + skin_ * balls.mean_diameter();
    built_from_ = balls;
    ++n_rebuilds_;
    std::vector<Entry> entries;
    entries.reserve(static_cast<std::size_t>(balls.size()));
    for (Index i = 0; i < balls.size(); ++i)
      entries.emplace_back(extent(balls.position[i], 0.5 * (balls.diameter[i] + listed_to_)), i);
    const boost::geometry::index::rtree<Entry, boost::geometry::index::quadratic<16>> tree(entries);
    pairs_.clear();
    std::vector<Entry> found;
    for (const auto& [box, i] : entries) {
      found.clear();
      tree.query(boost::geometry::index::intersects(box), std::back_inserter(found));
      for (const auto& [other_box, j] : found) {
        if (j <= i) continue;
        const double distance = 0.5 * (balls.diameter[i] + balls.diameter[j]) + listed_to_;
        if ((balls.position[i] - balls.position[j]).squaredNorm() <= distance * distance)
          pairs_.push_back({i, j});
      }
    }
    // The order the tree answers in depends on its shape; results must not.
    std::sort(pairs_.begin(), pairs_.end());
  }

  static Extent extent(const Vector<Dim>& centre, double half_width) {
    Extent box;
    set_corner(box.min_corner(), centre.array() - half_width);
    set_corner(box.max_corner(), centre.array() + half_width);
    return box;
  }
  static void set_corner(Point& corner, const Vector<Dim>& value) {
    corner.template set<0>(value[0]);
    corner.template set<1>(value[1]);
    if constexpr (Dim == 3) corner.template set<2>(value[2]);
  }

  double skin_;
  double listed_to_ = 0.0;
  Index n_rebuilds_ = 0;
  Balls<Dim> built_from_;
  Array<BallPair> pairs_;
};

static_assert(BroadPhase<RTree<2>, 2> && BroadPhase<RTree<3>, 3>);

}  // namespace jampack
