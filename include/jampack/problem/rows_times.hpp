// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstring>
#include <jampack/core/array.hpp>
#include <jampack/law/friction_cone.hpp>

namespace jampack {

// Vectors of the compiler (GCC takes no dependent sizes), split into what the processor has.
using TwoLanes [[gnu::vector_size(16)]] = double;
using FourLanes [[gnu::vector_size(32)]] = double;
using EightLanes [[gnu::vector_size(64)]] = double;

namespace detail {
/// sum += row * factor, the row read from memory.
template <class Lanes, class Factor>
[[gnu::always_inline]] inline void multiply_add(Lanes& sum, const double* row, const Factor& factor) {
  Lanes values;
  std::memcpy(&values, row, sizeof values);
  sum += values * factor;
}
}  // namespace detail

/// Sums u = A x in the making, A given as N long rows at a time: the inner loop of a sweep over what is
/// stored densely. Eight sums a row, so that additions do not wait for each other; they are folded once, at
/// the end, in an order that is fixed, whatever the processor. (No loops over N here and below: in them the
/// compiler keeps sums in memory.)
template <int N>
class RowSums {
 public:
  /// Rows of `width` scalars are best padded to a multiple of this.
  static constexpr Index lanes = 4;

  /// Adds A x for N rows of `width` scalars that lie `stride` apart.
  [[gnu::always_inline]] void add(const double* rows, Index width, Index stride, const double* x) {
    Index j = 0;
    for (; j + 8 <= width; j += 8) add_columns(eight_, rows + j, stride, x + j);
    if (j + 4 <= width) {
      add_columns(four_, rows + j, stride, x + j);
      j += 4;
    }
    for (; j < width; ++j) add_columns(rest_, rows + j, stride, x + j);
  }

  [[gnu::always_inline]] ContactVector<N> sums() const {
    ContactVector<N> u;
    u[0] = folded(eight_[0], four_[0], rest_[0]);
    if constexpr (N > 1) u[1] = folded(eight_[1], four_[1], rest_[1]);
    if constexpr (N > 2) u[2] = folded(eight_[2], four_[2], rest_[2]);
    return u;
  }

 private:
  // As many columns as `Lanes` has.
  template <class Lanes>
  [[gnu::always_inline]] static void add_columns(Lanes (&sum)[N], const double* rows, Index stride,
                                                 const double* x) {
    Lanes factor;
    std::memcpy(&factor, x, sizeof factor);
    detail::multiply_add(sum[0], rows, factor);
    if constexpr (N > 1) detail::multiply_add(sum[1], rows + stride, factor);
    if constexpr (N > 2) detail::multiply_add(sum[2], rows + 2 * stride, factor);
  }

  [[gnu::always_inline]] static double folded(const EightLanes& eight, const FourLanes& four, double rest) {
    const FourLanes low = __builtin_shufflevector(eight, eight, 0, 1, 2, 3),
                    high = __builtin_shufflevector(eight, eight, 4, 5, 6, 7);
    const FourLanes sum = (low + high) + four;
    return ((sum[0] + sum[2]) + (sum[1] + sum[3])) + rest;
  }

  EightLanes eight_[N] = {};
  FourLanes four_[N] = {};
  double rest_[N] = {};
};

/// A row of N x N blocks that lie scattered: what sparse rows cost least in. Blocks are stored one after the
/// other, column by column. The last one, whose factor may have been known for the shortest time, is
/// multiplied alone: only that product waits for it. In 3D four lanes are read of a column of three, and the
/// fourth sum is not used.
template <int N>
struct BlockRow {
  static constexpr Index stride = N * N;            ///< scalars from block to block
  static constexpr Index read_beyond = N == 3;      ///< scalars that must follow the last block
  static constexpr Index at_once = N == 1 ? 2 : 1;  ///< a row has a multiple of so many blocks, and one more

  /// Where entry (i, j) of a block is stored.
  static constexpr Index place(Index i, Index j) { return N * j + i; }

  /// Sum of block k times x + column[k], k = 0...n - 1.
  [[gnu::always_inline]] static ContactVector<N> times(const double* value, const std::int32_t* column,
                                                       Index n, const double* x) {
    using detail::multiply_add;
    ContactVector<N> u;
    if constexpr (N == 1) {
      TwoLanes sum = {};
      for (Index k = 0; k < n - 1; k += 2)
        multiply_add(sum, value + k, TwoLanes{x[column[k]], x[column[k + 1]]});
      u[0] = (sum[0] + sum[1]) + value[n - 1] * x[column[n - 1]];
    } else if constexpr (N == 2) {
      TwoLanes sum0 = {}, sum1 = {};
      for (Index k = 0; k < n - 1; ++k, value += stride) {
        const double* const a = x + column[k];
        multiply_add(sum0, value, a[0]);
        multiply_add(sum1, value + 2, a[1]);
      }
      TwoLanes sum = sum0 + sum1;
      const double* const last = x + column[n - 1];
      multiply_add(sum, value, last[0]);
      multiply_add(sum, value + 2, last[1]);
      u[0] = sum[0];
      u[1] = sum[1];
    } else {
      FourLanes sum0 = {}, sum1 = {}, sum2 = {};
      for (Index k = 0; k < n - 1; ++k, value += stride) {
        const double* const a = x + column[k];
        multiply_add(sum0, value, a[0]);
        multiply_add(sum1, value + 3, a[1]);
        multiply_add(sum2, value + 6, a[2]);
      }
      FourLanes sum = (sum0 + sum1) + sum2;
      const double* const last = x + column[n - 1];
      multiply_add(sum, value, last[0]);
      multiply_add(sum, value + 3, last[1]);
      multiply_add(sum, value + 6, last[2]);
      u[0] = sum[0];
      u[1] = sum[1];
      u[2] = sum[2];
    }
    return u;
  }
};

}  // namespace jampack
