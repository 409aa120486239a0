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
/// stored densely. Sixteen sums a row, so that additions do not wait for each other; they are folded once, at
/// the end, in an order that is fixed, whatever the processor. (No loops over N here and below: in them the
/// compiler keeps sums in memory.)
template <int N>
class RowSums {
 public:
  /// Adds A x for N rows of `width` scalars that lie `stride` apart. `in_lines`: x and all rows begin a cache
  /// line and fill lines (AlignedScalars), which is up to twice as fast.
  template <bool in_lines = false>
  [[gnu::always_inline]] void add(const double* rows, Index width, Index stride, const double* x) {
    Index j = 0;
    for (; j + 16 <= width; j += 16) {
      add_columns(eight_, rows + j, stride, x + j);
      add_columns(other_eight_, rows + j + 8, stride, x + j + 8);
    }
    for (; j + 8 <= width; j += 8) add_columns(eight_, rows + j, stride, x + j);
    if constexpr (in_lines) return;
    if (j + 4 <= width) {
      add_columns(four_, rows + j, stride, x + j);
      j += 4;
    }
    for (; j < width; ++j) add_columns(rest_, rows + j, stride, x + j);
  }

  [[gnu::always_inline]] ContactVector<N> sums() const {
    ContactVector<N> u;
    u[0] = folded(eight_[0] + other_eight_[0], four_[0], rest_[0]);
    if constexpr (N > 1) u[1] = folded(eight_[1] + other_eight_[1], four_[1], rest_[1]);
    if constexpr (N > 2) u[2] = folded(eight_[2] + other_eight_[2], four_[2], rest_[2]);
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

  EightLanes eight_[N] = {}, other_eight_[N] = {};
  FourLanes four_[N] = {};
  double rest_[N] = {};
};

/// A row of N x N blocks that lie scattered: what sparse rows cost least in. The last one, whose factor may
/// have been known for the shortest time, is multiplied alone: only that product waits for it. The others go
/// four at a time (two and one unknowns), so that rows of nearly the same length take the same branches, and
/// into sums that do not wait for each other. Entries lie row by row with two unknowns (a block and its
/// factor taken twice are one vector each), else column by column; in 3D four lanes are read of a column of
/// three, and the fourth sum is not used.
template <int N>
struct BlockRow {
  static constexpr Index stride = N * N;            ///< scalars from block to block
  static constexpr Index read_beyond = N == 3;      ///< scalars that must follow the last block
  static constexpr Index at_once = N == 3 ? 1 : 4;  ///< a row has a multiple of so many blocks, and one more

  /// Where entry (i, j) of a block is stored.
  static constexpr Index place(Index i, Index j) { return N == 2 ? N * i + j : N * j + i; }

  /// Sum of block k times x + column[k], k = 0...n - 2.
  [[gnu::always_inline]] static ContactVector<N> all_but_last(const double* value, const std::int32_t* column,
                                                              Index n, const double* x) {
    using detail::multiply_add;
    ContactVector<N> u;
    if constexpr (N == 1) {
      TwoLanes sum0 = {}, sum1 = {};
      for (Index k = 0; k < n - 1; k += 4) {
        multiply_add(sum0, value + k, TwoLanes{x[column[k]], x[column[k + 1]]});
        multiply_add(sum1, value + k + 2, TwoLanes{x[column[k + 2]], x[column[k + 3]]});
      }
      const TwoLanes sum = sum0 + sum1;
      u[0] = sum[0] + sum[1];
    } else if constexpr (N == 2) {
      // Row by row, and the even blocks apart from the odd ones.
      TwoLanes even0 = {}, even1 = {}, odd0 = {}, odd1 = {};
      for (Index k = 0; k < n - 1; k += 4, value += 4 * stride) {
        add_block(even0, even1, value, x + column[k]);
        add_block(odd0, odd1, value + stride, x + column[k + 1]);
        add_block(even0, even1, value + 2 * stride, x + column[k + 2]);
        add_block(odd0, odd1, value + 3 * stride, x + column[k + 3]);
      }
      const TwoLanes sum0 = even0 + odd0, sum1 = even1 + odd1;
      u[0] = sum0[0] + sum0[1];
      u[1] = sum1[0] + sum1[1];
    } else {
      FourLanes sum0 = {}, sum1 = {}, sum2 = {};
      for (Index k = 0; k < n - 1; ++k, value += stride) {
        const double* const a = x + column[k];
        multiply_add(sum0, value, a[0]);
        multiply_add(sum1, value + 3, a[1]);
        multiply_add(sum2, value + 6, a[2]);
      }
      const FourLanes sum = (sum0 + sum1) + sum2;
      u[0] = sum[0];
      u[1] = sum[1];
      u[2] = sum[2];
    }
    return u;
  }

  /// u + the last block, at `value`, times x.
  [[gnu::always_inline]] static ContactVector<N> add_last(ContactVector<N> u, const double* value,
                                                          const double* x) {
#pragma GCC unroll 9
    for (int k = 0; k < N * N; ++k) u[k % N] += value[place(k % N, k / N)] * x[k / N];
    return u;
  }

 private:
  [[gnu::always_inline]] static void add_block(TwoLanes& sum0, TwoLanes& sum1, const double* value,
                                               const double* x) {
    TwoLanes factor;
    std::memcpy(&factor, x, sizeof factor);
    detail::multiply_add(sum0, value, factor);
    detail::multiply_add(sum1, value + 2, factor);
  }
};

}  // namespace jampack
