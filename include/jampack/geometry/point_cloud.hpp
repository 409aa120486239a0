// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/core/array.hpp>
#include <jampack/core/dimension.hpp>
#include <limits>
#include <utility>

namespace jampack {

/// Points that are searched one and all, in blocks of eight that the processor takes at once.
template <int Dim>
class PointCloud {
 public:
  void assign(Index n) {
    // What fills the last block up is as far from everything as can be.
    blocks_.assign((n + width - 1) / width, Block::Constant(std::numeric_limits<double>::infinity()));
    size_ = n;
  }
  void set(Index i, const Vector<Dim>& x) { blocks_[i / width].row(i % width) = x.transpose(); }
  Index size() const { return size_; }

  /// The point nearest to x, the first of several, and its squared distance.
  std::pair<Index, double> nearest(const Vector<Dim>& x) const {
    std::pair<Index, double> best{-1, std::numeric_limits<double>::infinity()};
    for (Index k = 0; k < blocks_.size(); ++k) {
      Lanes d = (blocks_[k].col(0) - x[0]).square();
      for (int a = 1; a < Dim; ++a) d += (blocks_[k].col(a) - x[a]).square();
      if (!(d.minCoeff() < best.second)) continue;
      for (Index i = 0; i < width; ++i)
        if (d[i] < best.second) best = {k * width + i, d[i]};
    }
    return best;
  }

  /// How far the points reach in this direction: the largest product with it.
  double reach(const Vector<Dim>& direction) const {
    Lanes most = Lanes::Constant(-std::numeric_limits<double>::infinity());
    for (Index k = 0; k < size_ / width; ++k) {
      Lanes h = blocks_[k].col(0) * direction[0];
      for (int a = 1; a < Dim; ++a) h += blocks_[k].col(a) * direction[a];
      most = most.max(h);
    }
    double largest = most.maxCoeff();
    for (Index i = size_ / width * width; i < size_; ++i)
      largest = std::max(largest, direction.dot(blocks_[i / width].row(i % width).matrix()));
    return largest;
  }

 private:
  static constexpr int width = 8;
  using Lanes = Eigen::Array<double, width, 1>;
  using Block = Eigen::Array<double, width, Dim>;
  Array<Block> blocks_;
  Index size_ = 0;
};

}  // namespace jampack
