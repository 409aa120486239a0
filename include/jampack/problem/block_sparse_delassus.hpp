// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <jampack/core/error.hpp>
#include <jampack/problem/delassus.hpp>
#include <jampack/problem/rows_times.hpp>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>

namespace jampack {

/// One N x N block of a Delassus operator, given by its contacts.
template <int N>
struct DelassusBlock {
  Index row, column;
  Eigen::Matrix<double, N, N> value;
};

/// W stored row by row as its non-zero N x N blocks; need not be symmetric.
///
/// Neighbouring columns are kept as one run, and a run is stored as N contiguous scalar rows, so that a row
/// of W is read as a few long dot products whatever N is.
template <int N>
class BlockSparseDelassus {
 public:
  static constexpr int n_unknowns = N;
  using Block = Eigen::Matrix<double, N, N>;
  struct Motion {};

  BlockSparseDelassus() = default;

  /// Blocks in any order; blocks given twice are added. Throws InvalidInput for indices outside
  /// [0, n_contacts) and for values that are not finite.
  BlockSparseDelassus(Index n_contacts, Array<DelassusBlock<N>> blocks)
      : diagonal_(n_contacts, Block::Zero()) {
    for (const auto& block : blocks) {
      require(block.row >= 0 && block.row < n_contacts && block.column >= 0 && block.column < n_contacts,
              "Delassus operator: a block lies at (" + std::to_string(block.row) + ", " +
                  std::to_string(block.column) + "), outside of " + std::to_string(n_contacts) + " contacts");
      require(block.value.allFinite(),
              "Delassus operator: W is not finite at contact " + std::to_string(block.row));
    }
    // Places are sorted, not blocks: std::stable_sort's buffer ignores the alignment of fixed-size matrices.
    Array<Index> sorted(blocks.size());
    std::iota(sorted.begin(), sorted.end(), Index{0});
    std::sort(sorted.begin(), sorted.end(), [&](Index a, Index b) {
      return std::tuple(blocks[a].row, blocks[a].column, a) < std::tuple(blocks[b].row, blocks[b].column, b);
    });
    blocks = [&] {
      Array<DelassusBlock<N>> in_order;
      in_order.reserve(blocks.size());
      for (const Index k : sorted) in_order.push_back(blocks[k]);
      return in_order;
    }();
    row_start_.reserve(n_contacts + 1);
    Index k = 0;
    for (Index row = 0; row < n_contacts; ++row) {
      row_start_.push_back(runs_.size());
      while (k < blocks.size() && blocks[k].row == row) k = add_run(blocks, k);
    }
    row_start_.push_back(runs_.size());
  }

  Index n_contacts() const { return diagonal_.size(); }
  Index n_stored() const { return n_stored_; }  ///< scalars of W that are stored
  const Block& diagonal_block(Index c) const { return diagonal_[c]; }

  void apply(const Eigen::VectorXd& r, Eigen::VectorXd& u) const {
    u.resize(N * n_contacts());
    for (Index c = 0; c < n_contacts(); ++c) u.template segment<N>(N * c) = row_times(c, r.data());
  }

  Motion motion(const Eigen::VectorXd&) const { return {}; }
  ContactVector<N> velocity(const Motion&, const Eigen::VectorXd& r, Index c) const {
    return row_times(c, r.data());
  }
  void change(Motion&, Index, const ContactVector<N>&) const {}

  template <class Visit>
  void for_each_coupled_contact(Index c, Visit visit) const {
    for (Index k = row_start_[c]; k < row_start_[c + 1]; ++k)
      for (Index d = 0; d < runs_[k].length / N; ++d) visit(runs_[k].first / N + d);
  }

  /// Visits the stored blocks of row c as visit(column contact, block).
  template <class Visit>
  void for_each_block(Index c, Visit visit) const {
    for (Index k = row_start_[c]; k < row_start_[c + 1]; ++k) {
      const Run& run = runs_[k];
      for (Index d = 0; d < run.length / N; ++d) {
        Block block;
        for (int i = 0; i < N; ++i)
          for (int j = 0; j < N; ++j) block(i, j) = values_[run.start + place(run.length, i, d * N + j)];
        visit(run.first / N + d, block);
      }
    }
  }

 private:
  static constexpr Index long_run = N == 1 ? 0 : 32;  // scalar columns; measured, docs/results/solvers.md
  struct Run {
    Index start;          // of its values
    std::int32_t first;   // scalar column
    std::int32_t length;  // scalar columns
  };

  // Appends the run of neighbouring columns that begins at block k; returns the block after it.
  Index add_run(const Array<DelassusBlock<N>>& blocks, Index k) {
    const Index row = blocks[k].row, begin = k;
    Index last = blocks[k].column;
    for (++k; k < blocks.size() && blocks[k].row == row && blocks[k].column <= last + 1; ++k)
      last = blocks[k].column;
    const Index first = blocks[begin].column, length = N * (last - first + 1), start = values_.size();
    values_.resize(start + (length < long_run ? column_height<N> : N) * length, 0.0);
    for (Index b = begin; b < k; ++b) {
      const Index column = N * (blocks[b].column - first);
      for (int i = 0; i < N; ++i)
        for (int j = 0; j < N; ++j) values_[start + place(length, i, column + j)] += blocks[b].value(i, j);
      if (blocks[b].column == row) diagonal_[row] += blocks[b].value;
    }
    n_stored_ += N * length;
    runs_.push_back({start, static_cast<std::int32_t>(N * first), static_cast<std::int32_t>(length)});
    return k;
  }

  ContactVector<N> row_times(Index c, const double* r) const {
    ContactVector<N> u = ContactVector<N>::Zero();
    ColumnSums<N> short_runs;
    for (Index k = row_start_[c]; k < row_start_[c + 1]; ++k) {
      const Run& run = runs_[k];
      if (run.length < long_run)
        short_runs.add(values_.data() + run.start, run.length, r + run.first);
      else
        add_rows_times<N>(values_.data() + run.start, run.length, r + run.first, u);
    }
    short_runs.add_to(u);
    return u;
  }

  // Place of a block's value in its run; short runs lie column by column, long ones row by row.
  static Index place(Index length, Index i, Index j) {
    return length < long_run ? j * column_height<N> + i : i * length + j;
  }

  Array<Index> row_start_;
  Array<Run> runs_;
  Array<double> values_;
  Array<Block> diagonal_;
  Index n_stored_ = 0;
};

static_assert(DelassusOperator<BlockSparseDelassus<3>>);

}  // namespace jampack
