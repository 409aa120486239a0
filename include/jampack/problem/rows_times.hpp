// SPDX-License-Identifier: MIT
#pragma once

#include <cstring>
#include <jampack/core/array.hpp>
#include <jampack/law/friction_cone.hpp>
#include <type_traits>

namespace jampack {

/// u += A x for N contiguous rows of `width` scalars: the inner loop of a sweep over a stored Delassus
/// operator. Eight sums a row (vectors of the compiler, split into what the processor has), so that additions
/// do not wait for each other; their order is fixed, whatever the processor.
template <int N>
inline void add_rows_times(const double* rows, Index width, const double* x, ContactVector<N>& u) {
  using Lanes [[gnu::vector_size(64)]] = double;
  constexpr Index lanes = 8;
  const Index whole = width - width % lanes;
  if (whole > 0) {
    Lanes sum[N] = {};
    for (Index j = 0; j < whole; j += lanes) {
      Lanes factor, row;
      std::memcpy(&factor, x + j, sizeof factor);
      for (int i = 0; i < N; ++i) {
        std::memcpy(&row, rows + i * width + j, sizeof row);
        sum[i] += row * factor;
      }
    }
    for (int i = 0; i < N; ++i)
      u[i] += ((sum[i][0] + sum[i][4]) + (sum[i][1] + sum[i][5])) +
              ((sum[i][2] + sum[i][6]) + (sum[i][3] + sum[i][7]));
  }
  for (int i = 0; i < N; ++i) {
    double rest = 0;
    for (Index j = whole; j < width; ++j) rest += rows[i * width + j] * x[j];
    u[i] += rest;
  }
}

/// Rows a column takes in the column form: N, padded to what vectors hold.
template <int N>
inline constexpr Index column_height = N == 3 ? 4 : 2;

// Vectors of the compiler (GCC takes no dependent sizes).
using TwoLanes [[gnu::vector_size(16)]] = double;
using FourLanes [[gnu::vector_size(32)]] = double;

/// Sums of columns in the making: three chains, as additions to one would wait for each other.
template <int N>
struct ColumnSums {
  using Lanes = std::conditional_t<column_height<N> == 4, FourLanes, TwoLanes>;
  Lanes chain[3] = {};

  /// Adds A x for a block of N rows stored column by column, `width` (a multiple of N) columns: what short
  /// runs of a sparse row cost least in.
  void add(const double* columns, Index width, const double* x) {
    for (Index j = 0; j < width; j += N)
      for (int k = 0; k < N; ++k) {
        Lanes column;
        std::memcpy(&column, columns + (j + k) * column_height<N>, sizeof column);
        chain[k] += column * x[j + k];
      }
  }
  void add_to(ContactVector<N>& u) const {
    const Lanes sum = (chain[0] + chain[1]) + chain[2];
    for (int i = 0; i < N; ++i) u[i] += sum[i];
  }
};

}  // namespace jampack
