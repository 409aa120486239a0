// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <jampack/core/array.hpp>
#include <jampack/core/dimension.hpp>
#include <set>

namespace jampack {

/// Which Dim x Dim node blocks a grain's symmetric matrices have: compressed rows with sorted columns,
/// both triangles. One pattern serves every grain of a reference mesh.
struct BlockPattern {
  Array<std::int32_t> row_start;
  Array<std::int32_t> column;

  Index n_rows() const { return row_start.size() - 1; }
  Index n_blocks() const { return column.size(); }

  /// Position of block (i, j), which must be in the pattern.
  Index position(Index i, Index j) const {
    const auto* first = column.data() + row_start[i];
    const auto* last = column.data() + row_start[i + 1];
    const auto* found = std::lower_bound(first, last, static_cast<std::int32_t>(j));
    assert(found != last && *found == j);
    return found - column.data();
  }
};

/// Pattern that couples all nodes of each given group with each other.
template <class Groups>
BlockPattern block_pattern(Index n_nodes, const Groups& groups) {
  Array<std::set<std::int32_t>> rows(n_nodes);
  for (const auto& group : groups)
    for (const Index i : group)
      for (const Index j : group) rows[i].insert(static_cast<std::int32_t>(j));
  BlockPattern pattern;
  pattern.row_start.push_back(0);
  for (Index i = 0; i < n_nodes; ++i) {
    rows[i].insert(static_cast<std::int32_t>(i));
    pattern.column.insert(pattern.column.end(), rows[i].begin(), rows[i].end());
    pattern.row_start.push_back(static_cast<std::int32_t>(pattern.column.size()));
  }
  return pattern;
}

/// Values on a BlockPattern.
template <int Dim>
struct BlockMatrix {
  Array<Matrix<Dim>> block;

  void set_zero(const BlockPattern& pattern) { block.assign(pattern.n_blocks(), Matrix<Dim>::Zero()); }

  /// y += A x, with x and y of Dim * n_rows entries.
  void add_product(const BlockPattern& pattern, const double* x, double* y) const {
    for (Index i = 0; i < pattern.n_rows(); ++i) {
      Vector<Dim> sum = Vector<Dim>::Zero();
      for (Index k = pattern.row_start[i]; k < pattern.row_start[i + 1]; ++k)
        sum.noalias() += block[k] * Eigen::Map<const Vector<Dim>>(x + Dim * pattern.column[k]);
      Eigen::Map<Vector<Dim>>(y + Dim * i) += sum;
    }
  }
};

}  // namespace jampack
