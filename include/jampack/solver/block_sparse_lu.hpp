// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/LU>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cstring>
#include <jampack/core/array.hpp>
#include <jampack/law/friction_cone.hpp>
#include <jampack/problem/block_sparse_delassus.hpp>
#include <vector>

namespace jampack {

/// LU factors of a sparse matrix of N x N blocks whose pattern is symmetric (its values need not be), without
/// pivoting between blocks: for matrices with good diagonal blocks, such as regularised Delassus operators.
/// Ordered by approximate minimum degree once for the pattern; factorised row by row as often as wanted.
/// Neighbouring columns of a row of U lie together and are padded to whole vectors.
template <int N>
class BlockSparseLU {
 public:
  using Block = Eigen::Matrix<double, N, N>;

  /// neighbours[i] holds the columns of row i (i itself or not, each once); must be symmetric.
  void analyse(const Array<Array<Index>>& neighbours) {
    n_ = neighbours.size();
    order(neighbours);
    // Row k of U: what row k of the matrix has right of k, and what the rows whose first entry is k had.
    Array<Array<Index>> children(n_);
    Array<Index> mark(n_, Index{-1});
    u_column_.clear();
    u_start_.assign(1, 0);
    Array<Index> row;
    for (Index k = 0; k < n_; ++k) {
      row.clear();
      mark[k] = k;
      const auto add = [&](Index j) {
        if (j > k && mark[j] != k) {
          mark[j] = k;
          row.push_back(j);
        }
      };
      for (const Index j : neighbours[contact_[k]]) add(place_[j]);
      for (const Index child : children[k])
        for (Index m = u_start_[child]; m < u_start_[child + 1]; ++m) add(u_column_[m]);
      std::sort(row.begin(), row.end());
      if (!row.empty()) children[row.front()].push_back(k);
      u_column_.insert(u_column_.end(), row.begin(), row.end());
      u_start_.push_back(u_column_.size());
    }
    lay_out();
  }

  Index n_blocks() const { return u_column_.size(); }  ///< of U off the diagonal, as many as of L

  /// Floating-point operations of a factorisation.
  double work() const {
    double sum = 0;
    for (Index k = 0; k < n_; ++k) {
      const double row = static_cast<double>(u_start_[k + 1] - u_start_[k]);
      sum += 2.0 * N * N * N * (row + row * row);
    }
    return sum;
  }

  /// Factorises the matrix whose row i is given by row(i, add), which calls add(column, block) for each of
  /// its blocks; blocks given twice are added. False if a pivot block is singular.
  template <class Row>
  bool factorise(Row&& row) {
    for (Index i = 0; i < n_; ++i) {
      clear_row(i);
      row(contact_[i], [&](Index column, const Block& block) {
        const Index j = N * place_[column];
        for (int a = 0; a < N; ++a)
          for (int b = 0; b < N; ++b) work_[a][j + b] += block(a, b);
      });
      for (Index m = l_start_[i]; m < l_start_[i + 1]; ++m) {
        const Index k = l_column_[m];
        const Block block = work_block(k);
        l_value_[m].setZero();
        if (block.isZero(0)) continue;
        l_value_[m].noalias() = block.lazyProduct(inverse_pivot_[k]);
        eliminate(l_value_[m], k);
      }
      const Block pivot = work_block(i);
      const double size = pivot.cwiseAbs().maxCoeff();
      if (!(size > 0)) return false;
      inverse_pivot_[i] = (pivot / size).inverse() / size;
      if (!inverse_pivot_[i].allFinite()) return false;
      store_row(i);
    }
    return true;
  }

  /// x becomes the solution for the right-hand side x (N values a row, in the matrix's own order).
  void solve(Eigen::VectorXd& x) const {
    for (Index i = 0; i < n_; ++i) {
      ContactVector<N> y = x.template segment<N>(N * contact_[i]);
      for (Index m = l_start_[i]; m < l_start_[i + 1]; ++m)
        y -= l_value_[m] * solution_.template segment<N>(N * l_column_[m]);
      solution_.template segment<N>(N * i) = y;
    }
    for (Index i = n_ - 1; i >= 0; --i) {
      ContactVector<N> y = solution_.template segment<N>(N * i);
      for (Index m = run_start_[i]; m < run_start_[i + 1]; ++m) {
        const Run& run = runs_[m];
        for (int a = 0; a < N; ++a)
          for (Index j = 0; j < run.length; ++j)
            y[a] -= u_value_[run.start + a * run.padded + j] * solution_[run.first + j];
      }
      solution_.template segment<N>(N * i) = inverse_pivot_[i] * y;
      x.template segment<N>(N * contact_[i]) = solution_.template segment<N>(N * i);
    }
  }

 private:
  struct Run {
    Index start;   // of its values: N rows of `padded` scalars
    Index first;   // scalar column
    Index length;  // scalar columns
    Index padded;
  };

  void order(const Array<Array<Index>>& neighbours) {
    std::vector<Eigen::Triplet<double>> entries;
    for (Index i = 0; i < n_; ++i)
      for (const Index j : neighbours[i]) entries.emplace_back(static_cast<int>(i), static_cast<int>(j), 1.0);
    Eigen::SparseMatrix<double> pattern(n_, n_);
    pattern.setFromTriplets(entries.begin(), entries.end());
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
    Eigen::AMDOrdering<int>()(pattern, permutation);
    contact_.resize(n_);
    place_.resize(n_);
    for (Index i = 0; i < n_; ++i) {
      contact_[i] = permutation.indices()[i];
      place_[contact_[i]] = i;
    }
  }

  void lay_out() {
    l_start_.assign(n_ + 1, 0);
    for (const Index j : u_column_) ++l_start_[j + 1];
    for (Index i = 0; i < n_; ++i) l_start_[i + 1] += l_start_[i];
    l_column_.resize(u_column_.size());
    Array<Index> next(l_start_.begin(), l_start_.end());
    runs_.clear();
    run_start_.assign(1, 0);
    Index n_values = 0;
    for (Index k = 0; k < n_; ++k) {
      for (Index m = u_start_[k]; m < u_start_[k + 1];) {
        const Index begin = m;
        for (++m; m < u_start_[k + 1] && u_column_[m] == u_column_[m - 1] + 1;) ++m;
        const Index length = N * (m - begin), padded = (length + 3) / 4 * 4;
        runs_.push_back({n_values, N * u_column_[begin], length, padded});
        n_values += N * padded;
      }
      run_start_.push_back(runs_.size());
      for (Index m = u_start_[k]; m < u_start_[k + 1]; ++m) l_column_[next[u_column_[m]]++] = k;
    }
    u_value_.assign(n_values, 0.0);
    l_value_.assign(l_column_.size(), Block::Zero());
    inverse_pivot_.assign(n_, Block::Zero());
    for (auto& row : work_) row.assign(N * n_ + 4, 0.0);
    solution_.resize(N * n_);
  }

  Block work_block(Index k) const {
    Block block;
    for (int a = 0; a < N; ++a)
      for (int b = 0; b < N; ++b) block(a, b) = work_[a][N * k + b];
    return block;
  }

  void clear_row(Index i) {
    for (int a = 0; a < N; ++a) {
      double* const row = work_[a].data();
      for (Index m = l_start_[i]; m < l_start_[i + 1]; ++m)
        for (int b = 0; b < N; ++b) row[N * l_column_[m] + b] = 0;
      for (int b = 0; b < N; ++b) row[N * i + b] = 0;
      for (Index m = run_start_[i]; m < run_start_[i + 1]; ++m)
        std::fill_n(row + runs_[m].first, runs_[m].length, 0.0);
    }
  }

  // work -= factor * (row k of U)
  void eliminate(const Block& factor, Index k) {
    for (Index m = run_start_[k]; m < run_start_[k + 1]; ++m) {
      const Run& run = runs_[m];
      const double* const u = u_value_.data() + run.start;
      Index j = 0;
      for (; j + 8 <= run.padded; j += 8)
        eliminate_columns<EightLanes>(factor, u + j, run.padded, run.first + j);
      if (j < run.padded) eliminate_columns<FourLanes>(factor, u + j, run.padded, run.first + j);
    }
  }

  // As many columns as `Lanes` has, from `column` on. Unrolled: a factor's entries would be read again and
  // again.
  template <class Lanes>
  [[gnu::always_inline]] void eliminate_columns(const Block& factor, const double* values, Index stride,
                                                Index column) {
    Lanes u[N];
#pragma GCC unroll 9
    for (int b = 0; b < N; ++b) std::memcpy(&u[b], values + b * stride, sizeof u[b]);
#pragma GCC unroll 9
    for (int a = 0; a < N; ++a) {
      double* const target = work_[a].data() + column;
      Lanes w;
      std::memcpy(&w, target, sizeof w);
#pragma GCC unroll 9
      for (int b = 0; b < N; ++b) w -= factor(a, b) * u[b];
      std::memcpy(target, &w, sizeof w);
    }
  }

  void store_row(Index i) {
    for (Index m = run_start_[i]; m < run_start_[i + 1]; ++m) {
      const Run& run = runs_[m];
      for (int a = 0; a < N; ++a)
        std::copy_n(work_[a].data() + run.first, run.length, u_value_.data() + run.start + a * run.padded);
    }
  }

  Index n_ = 0;
  Array<Index> contact_, place_;     // contact at a place in the order of elimination, and back
  Array<Index> u_start_, u_column_;  // pattern of U right of the diagonal
  Array<Index> l_start_, l_column_;  // pattern of L, by rows
  Array<Index> run_start_;
  Array<Run> runs_;
  Array<double> u_value_;
  Array<Block> l_value_, inverse_pivot_;
  Array<double> work_[N];
  mutable Eigen::VectorXd solution_;
};

/// Neighbours of each row of W, made symmetric where the pattern of W is not: what analyse() takes.
template <int N>
Array<Array<Index>> symmetric_pattern(const BlockSparseDelassus<N>& w) {
  Array<Array<Index>> neighbours(w.n_contacts());
  for (Index c = 0; c < w.n_contacts(); ++c)
    w.for_each_coupled_contact(c, [&](Index d) {
      neighbours[c].push_back(d);
      neighbours[d].push_back(c);
    });
  for (auto& list : neighbours) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return neighbours;
}

}  // namespace jampack
