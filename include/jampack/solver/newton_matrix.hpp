// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/core/parallel.hpp>
#include <jampack/problem/stored_blocks.hpp>
#include <jampack/solver/block_sparse_lu.hpp>

namespace jampack {

/// Solves with the matrix A W + C of a Newton step on contacts, A and C block diagonal. A contact takes part
/// with its first n_rows unknowns: 0 where it is open, 1 without friction, else N. W is held as stored
/// blocks; what is known of its structure may be used instead (solver/grain_newton_matrix.hpp).
template <class Delassus>
class NewtonMatrix {
 public:
  static constexpr int N = Delassus::n_unknowns;
  using Block = Eigen::Matrix<double, N, N>;
  /// What W must be stored as.
  using Stored = BlockSparseDelassus<N>;
  static decltype(auto) stored(const Delassus& w) { return as_block_sparse(w); }

  /// Sweeps that take as long as one factorisation: of a full matrix of n rows n/3, of a sparse one with as
  /// many entries a row little more. 0 where that is not known without the matrix.
  static Index factorisation_in_sweeps(const Delassus& w) {
    if constexpr (requires { w.n_stored(); })
      return w.n_stored() / (N * w.n_contacts()) / 3;
    else
      return 0;
  }

  /// `w` must outlive the matrix.
  explicit NewtonMatrix(const Stored& w, Threads = {}) : w_(w) { lu_.analyse(symmetric_pattern(w)); }

  /// x, the right-hand side, becomes the solution; unknowns that do not take part stay as they are. False,
  /// with x of no use, if the matrix cannot be solved with.
  bool solve(const Array<int>& n_rows, const Array<Block>& a, const Array<Block>& constant,
             Eigen::VectorXd& x) {
    const bool factorised = lu_.factorise([&](Index c, auto add) {
      Block rest = part(constant[c], n_rows[c], n_rows[c]);
      for (int i = n_rows[c]; i < N; ++i) rest(i, i) = 1;
      add(c, rest);
      if (n_rows[c] == 0) return;
      w_.for_each_block(c, [&](Index d, const Block& block) {
        if (n_rows[d] > 0) add(d, part(product(a[c], block), n_rows[c], n_rows[d]));
      });
    });
    if (factorised) lu_.solve(x);
    return factorised && x.allFinite();
  }

 private:
  // Scalar by scalar, all inlined: a product of Eigen's is a call, and corners of any size are loops.
  [[gnu::always_inline]] static Block product(const Block& a, const Block& b) {
    Block c;
#pragma GCC unroll 9
    for (int j = 0; j < N; ++j)
#pragma GCC unroll 9
      for (int i = 0; i < N; ++i) {
        double sum = a(i, 0) * b(0, j);
#pragma GCC unroll 9
        for (int k = 1; k < N; ++k) sum += a(i, k) * b(k, j);
        c(i, j) = sum;
      }
    return c;
  }
  // The block with zeros beyond these rows and columns.
  [[gnu::always_inline]] static Block part(const Block& block, int n_rows, int n_columns) {
    Block kept;
#pragma GCC unroll 9
    for (int j = 0; j < N; ++j)
#pragma GCC unroll 9
      for (int i = 0; i < N; ++i) kept(i, j) = i < n_rows && j < n_columns ? block(i, j) : 0.0;
    return kept;
  }

  const Stored& w_;
  BlockSparseLU<N> lu_;
};

}  // namespace jampack
