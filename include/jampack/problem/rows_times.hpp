// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/core/array.hpp>
#include <jampack/law/friction_cone.hpp>

namespace jampack {

/// u += A x for N contiguous rows of `width` scalars: the inner loop of a sweep over a stored Delassus
/// operator. Eight sums a row, so that the additions do not wait for each other and compilers vectorise them
/// without being allowed to reorder; the order is fixed, whatever the processor.
template <int N>
inline void add_rows_times(const double* rows, Index width, const double* x, ContactVector<N>& u) {
  constexpr Index lanes = 8;
  const Index whole = width - width % lanes;
  if (whole > 0) {
    double sum[N][lanes] = {};
    for (Index j = 0; j < whole; j += lanes)
      for (int i = 0; i < N; ++i)
        for (Index lane = 0; lane < lanes; ++lane) sum[i][lane] += rows[i * width + j + lane] * x[j + lane];
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

}  // namespace jampack
