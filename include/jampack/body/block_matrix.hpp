// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cstdint>
#include <jampack/core/array.hpp>
#include <jampack/core/dimension.hpp>
#include <memory>
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

/// Sparse Cholesky factorisation of a symmetric BlockMatrix; the ordering is found once for a pattern.
template <int Dim>
class BlockCholesky {
 public:
  /// Finds the ordering and the map from blocks to the scalar lower triangle.
  void analyse(const BlockPattern& pattern) {
    using Triplet = Eigen::Triplet<double, int>;
    std::vector<Triplet> entries;
    for (int i = 0; i < pattern.n_rows(); ++i)
      for (Index k = pattern.row_start[i]; k < pattern.row_start[i + 1]; ++k)
        for (int r = 0; r < Dim; ++r)
          for (int c = 0; c < Dim; ++c)
            if (Dim * i + r >= Dim * pattern.column[k] + c)
              entries.emplace_back(Dim * i + r, Dim * pattern.column[k] + c,
                                   static_cast<double>(k * Dim * Dim + c * Dim + r));
    const auto n = Dim * pattern.n_rows();
    lower_.resize(n, n);
    lower_.setFromTriplets(entries.begin(), entries.end());
    source_.clear();
    for (Index k = 0; k < lower_.nonZeros(); ++k) source_.push_back(Index(lower_.valuePtr()[k]));
    factor_->analyzePattern(lower_);
  }

  /// Factorises; false when the matrix is not positive definite (nothing usable is left then).
  bool factorise(const BlockMatrix<Dim>& matrix) {
    const double* values = matrix.block.data()->data();
    for (Index k = 0; k < source_.size(); ++k) lower_.valuePtr()[k] = values[source_[k]];
    factor_->factorize(lower_);
    return factor_->info() == Eigen::Success;
  }

  template <class RightHandSide>
  auto solve(const RightHandSide& b) const {
    return factor_->solve(b);
  }

  /// With the matrix P^T L L^T P: b becomes L^-1 P b. One row of b a degree of freedom, so that all its
  /// columns are worked on at once.
  void forward(Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>& b) const {
    b = factor_->permutationP() * b;
    const auto& lower = factor_->matrixL().nestedExpression();
    const auto* start = lower.outerIndexPtr();
    const auto* row = lower.innerIndexPtr();
    const double* value = lower.valuePtr();
    for (Eigen::Index j = 0; j < lower.cols(); ++j) {
      auto pivot = b.row(j);
      pivot /= value[start[j]];
      for (auto k = start[j] + 1; k < start[j + 1]; ++k) b.row(row[k]).noalias() -= value[k] * pivot;
    }
  }
  /// y becomes P^T L^-T y.
  void backward(Eigen::VectorXd& y) const {
    factor_->matrixU().solveInPlace(y);
    y = factor_->permutationPinv() * y;
  }

 private:
  Eigen::SparseMatrix<double> lower_;
  Array<Index> source_;
  using Factor = Eigen::SimplicialLLT<Eigen::SparseMatrix<double>>;
  std::unique_ptr<Factor> factor_ = std::make_unique<Factor>();  // Eigen's cannot be moved
};

}  // namespace jampack
