// SPDX-License-Identifier: MIT
#pragma once

#include <utility>

namespace jampack {

/// visit(0), ..., visit(N - 1), written out: compilers leave loops as short as a contact's unknowns rolled,
/// and what a loop indexes lies in memory, where the next operation has to wait for it.
template <int N, class Visit>
[[gnu::always_inline]] inline void unroll(const Visit& visit) {
  [&visit]<int... i>(std::integer_sequence<int, i...>) __attribute__((always_inline)) {
    (visit(i), ...);
  }
  (std::make_integer_sequence<int, N>{});
}

}  // namespace jampack
