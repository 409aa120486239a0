// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstring>
#include <jampack/core/array.hpp>
#include <jampack/law/friction_cone.hpp>

namespace jampack {

// Vectors of the compiler (GCC takes no dependent sizes), split into what the processor has.
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
/// other, columns padded to whole vectors; several blocks at a time, as additions to one sum would wait for
/// each other.
template <int N>
struct BlockRow {
  static constexpr Index stride = N == 1 ? 1 : N == 2 ? 4 : 12;  ///< scalars a block takes
  static constexpr Index at_once = N == 1 ? 4 : 2;               ///< a row has a multiple of so many blocks

  /// Where entry (i, j) of a block is stored.
  static constexpr Index place(Index i, Index j) { return N == 3 ? 4 * j + i : N * j + i; }

  /// Sum of block k times x + column[k], k = 0...n - 1. What is added last is waited for the shortest.
  [[gnu::always_inline]] static ContactVector<N> times(const double* value, const std::int32_t* column,
                                                       Index n, const double* x) {
    using detail::multiply_add;
    ContactVector<N> u;
    if constexpr (N == 1) {
      double sum0 = 0, sum1 = 0, sum2 = 0, sum3 = 0;
      for (Index k = 0; k < n; k += 4) {
        sum0 += value[k] * x[column[k]];
        sum1 += value[k + 1] * x[column[k + 1]];
        sum2 += value[k + 2] * x[column[k + 2]];
        sum3 += value[k + 3] * x[column[k + 3]];
      }
      u[0] = (sum0 + sum1) + (sum2 + sum3);
    } else if constexpr (N == 2) {
      FourLanes even = {}, odd = {};
      for (Index k = 0; k < n; k += 2, value += 2 * stride) {
        const double *const a = x + column[k], *const b = x + column[k + 1];
        multiply_add(even, value, FourLanes{a[0], a[0], a[1], a[1]});
        multiply_add(odd, value + stride, FourLanes{b[0], b[0], b[1], b[1]});
      }
      const FourLanes sum = even + odd;
      u[0] = sum[0] + sum[2];
      u[1] = sum[1] + sum[3];
    } else {
      FourLanes even0 = {}, even1 = {}, even2 = {}, odd0 = {}, odd1 = {}, odd2 = {};
      for (Index k = 0; k < n; k += 2, value += 2 * stride) {
        const double *const a = x + column[k], *const b = x + column[k + 1];
        multiply_add(even0, value, a[0]);
        multiply_add(even1, value + 4, a[1]);
        multiply_add(even2, value + 8, a[2]);
        multiply_add(odd0, value + stride, b[0]);
        multiply_add(odd1, value + stride + 4, b[1]);
        multiply_add(odd2, value + stride + 8, b[2]);
      }
      const FourLanes sum = ((even0 + odd0) + (even1 + odd1)) + (even2 + odd2);
      u[0] = sum[0];
      u[1] = sum[1];
      u[2] = sum[2];
    }
    return u;
  }
};

}  // namespace jampack
