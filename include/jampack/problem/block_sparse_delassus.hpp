// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <jampack/core/aligned_scalars.hpp>
#include <jampack/core/error.hpp>
#include <jampack/problem/delassus.hpp>
#include <jampack/problem/rows_times.hpp>
#include <limits>
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
/// Blocks in many neighbouring columns are kept as one run, N contiguous scalar rows, which are read as long
/// dot products; the others one by one, in the order in which a sweep through the rows comes to know what
/// they multiply.
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
    Index k = 0;
    for (Index row = 0; row < n_contacts; ++row) {
      rows_.push_back({columns_.size(), 0, runs_.size()});
      while (k < blocks.size() && blocks[k].row == row) k = add_neighbours(blocks, k);
      sort_for_sweeps(row);
    }
    rows_.push_back({columns_.size(), 0, runs_.size()});
    block_values_.resize(block_values_.size() + BlockRow<N>::read_beyond, 0.0);
  }

  Index n_contacts() const { return diagonal_.size(); }
  Index n_stored() const { return n_stored_; }  ///< scalars of W that are stored
  const Block& diagonal_block(Index c) const { return diagonal_[c]; }

  void apply(const Eigen::VectorXd& r, Eigen::VectorXd& u) const {
    u.resize(N * n_contacts());
    for (Index c = 0; c < n_contacts(); ++c) u.template segment<N>(N * c) = row_times(c, r.data());
  }

  Motion motion(const Eigen::VectorXd&) const { return {}; }
  [[gnu::always_inline]] ContactVector<N> velocity(const Motion&, const Eigen::VectorXd& r, Index c) const {
    return row_times(c, r.data());
  }
  void change(Motion&, Index, const ContactVector<N>&) const {}

  /// The velocity in two parts, so that the next contact's can be begun before a contact is solved: what does
  /// not read r_{c-1}, and the rest.
  [[gnu::always_inline]] ContactVector<N> begin_velocity(const Eigen::VectorXd& r, Index c) const {
    return begin_row(c, r.data());
  }
  [[gnu::always_inline]] ContactVector<N> end_velocity(const ContactVector<N>& begun,
                                                       const Eigen::VectorXd& r, Index c) const {
    return end_row(begun, c, r.data());
  }

  template <class Visit>
  void for_each_coupled_contact(Index c, Visit visit) const {
    for_each_place(c, [&](Index d, const double*, Index) { visit(d); });
  }

  /// Whether rows lie so far away that it is worth asking for them ahead of time, and how. Measured: only
  /// with two unknowns (a fifth of an update); with one it costs as much, with three there is enough time.
  bool is_far() const { return n_stored_ > 200000; }
  [[gnu::always_inline]] void fetch_row(Index c) const  // a call would be left out, having no effect
      requires(N == 2) {
    const Index first = rows_[c].first_block, last = rows_[c + 1].first_block;
    for (Index k = BlockRow<N>::stride * first; k < BlockRow<N>::stride * last; k += 8)
      __builtin_prefetch(block_values_.data() + k);
    __builtin_prefetch(columns_.data() + first);
    __builtin_prefetch(columns_.data() + last - 1);
  }

  /// Visits the stored blocks of row c as visit(column contact, block).
  template <class Visit>
  void for_each_block(Index c, Visit visit) const {
    for_each_place(c, [&](Index d, const double* value, Index row_stride) {
      Block block;
      for (int i = 0; i < N; ++i)
        for (int j = 0; j < N; ++j)
          block(i, j) = value[row_stride > 0 ? i * row_stride + j : BlockRow<N>::place(i, j)];
      visit(d, block);
    });
  }

 private:
  static constexpr Index long_run = 32;  // scalar columns; measured, docs/results/solvers.md
  struct Run {
    Index start;          // of its values
    std::int32_t first;   // scalar column
    std::int32_t length;  // scalar columns
  };
  struct Row {
    Index first_block, padding;  // so many blocks are zeros, in front
    Index first_run;
  };

  // Appends the blocks in neighbouring columns that begin at block k; returns the block after them.
  Index add_neighbours(const Array<DelassusBlock<N>>& blocks, Index k) {
    const Index row = blocks[k].row, begin = k;
    for (++k; k < blocks.size() && blocks[k].row == row && blocks[k].column <= blocks[k - 1].column + 1;) ++k;
    const Index first = blocks[begin].column, n = blocks[k - 1].column - first + 1, length = N * n;
    const bool as_run = length >= long_run;
    const Index start = as_run ? n_run_values_ : block_values_.size(),
                stride = AlignedScalars::padded(length);
    if (as_run) {
      n_run_values_ += N * stride;
      run_values_.resize(n_run_values_);
      runs_.push_back({start, static_cast<std::int32_t>(N * first), static_cast<std::int32_t>(length)});
    } else {
      block_values_.resize(start + BlockRow<N>::stride * n, 0.0);
      for (Index d = 0; d < n; ++d) columns_.push_back(static_cast<std::int32_t>(N * (first + d)));
    }
    for (Index b = begin; b < k; ++b) {
      const Index d = blocks[b].column - first;
      for (int i = 0; i < N; ++i)
        for (int j = 0; j < N; ++j)
          (as_run ? run_values_.data()[start + i * stride + N * d + j]
                  : block_values_[start + BlockRow<N>::stride * d + BlockRow<N>::place(i, j)]) +=
              blocks[b].value(i, j);
      if (blocks[b].column == row) diagonal_[row] += blocks[b].value;
    }
    n_stored_ += N * length;
    return k;
  }

  // The row's blocks that lie one by one: the diagonal, then the farthest from it first, that of the row
  // before last; and in front zeros that make them as many as BlockRow takes.
  void sort_for_sweeps(Index row) {
    constexpr Index stride = BlockRow<N>::stride, at_once = BlockRow<N>::at_once;
    const Index first = rows_[row].first_block, n = columns_.size() - first;
    Array<Index> order(n);
    std::iota(order.begin(), order.end(), Index{0});
    const auto early = [&](Index k) {
      const Index d = columns_[first + k] - N * row;
      return d == 0 ? std::numeric_limits<Index>::max() : 2 * std::abs(d) + (d > 0 ? 1 : 0);
    };
    std::sort(order.begin(), order.end(), [&](Index a, Index b) { return early(a) > early(b); });
    const Array<std::int32_t> columns(columns_.begin() + first, columns_.end());
    const Array<double> values(block_values_.begin() + stride * first, block_values_.end());
    const Index padding = n == 0 ? 1 : (at_once + 1 - n % at_once) % at_once;
    rows_[row].padding = padding;
    columns_.resize(first);
    columns_.resize(first + padding + n, static_cast<std::int32_t>(N * row));
    block_values_.resize(stride * first);
    block_values_.resize(stride * (first + padding + n), 0.0);
    for (Index k = 0; k < n; ++k) {
      const Index place = first + padding + k;
      columns_[place] = columns[order[k]];
      std::copy_n(values.data() + stride * order[k], stride, block_values_.data() + stride * place);
    }
  }

  // Visits the blocks of row c as visit(column contact, first value, scalars from row to row: 0 in a block
  // that lies by itself).
  template <class Visit>
  void for_each_place(Index c, Visit visit) const {
    for (Index k = rows_[c].first_block + rows_[c].padding; k < rows_[c + 1].first_block; ++k)
      visit(columns_[k] / N, block_values_.data() + BlockRow<N>::stride * k, Index{0});
    for (Index k = rows_[c].first_run; k < rows_[c + 1].first_run; ++k) {
      const Run& run = runs_[k];
      for (Index j = 0; j < run.length; j += N)
        visit((run.first + j) / N, run_values_.data() + run.start + j, AlignedScalars::padded(run.length));
    }
  }

  [[gnu::always_inline]] ContactVector<N> row_times(Index c, const double* r) const {
    return end_row(begin_row(c, r), c, r);
  }

  [[gnu::always_inline]] ContactVector<N> begin_row(Index c, const double* r) const {
    const Index first = rows_[c].first_block;
    return BlockRow<N>::all_but_last(block_values_.data() + BlockRow<N>::stride * first,
                                     columns_.data() + first, rows_[c + 1].first_block - first, r);
  }

  [[gnu::always_inline]] ContactVector<N> end_row(const ContactVector<N>& begun, Index c,
                                                  const double* r) const {
    const Row &row = rows_[c], &next = rows_[c + 1];
    const Index last = next.first_block - 1;
    ContactVector<N> u =
        BlockRow<N>::add_last(begun, block_values_.data() + BlockRow<N>::stride * last, r + columns_[last]);
    if (row.first_run != next.first_run) {
      RowSums<N> runs;
      for (Index k = row.first_run; k < next.first_run; ++k)
        runs.add(run_values_.data() + runs_[k].start, runs_[k].length,
                 AlignedScalars::padded(runs_[k].length), r + runs_[k].first);
      const ContactVector<N> of_runs = runs.sums();
#pragma GCC unroll 9
      for (int i = 0; i < N; ++i) u[i] += of_runs[i];
    }
    return u;
  }

  Array<Row> rows_;
  Array<std::int32_t> columns_;  // scalar column of each block that lies by itself
  Array<double> block_values_;
  Array<Run> runs_;
  AlignedScalars run_values_;  // each row begins a cache line
  Array<Block> diagonal_;
  Index n_stored_ = 0, n_run_values_ = 0;
};

static_assert(DelassusOperator<BlockSparseDelassus<3>>);

}  // namespace jampack
