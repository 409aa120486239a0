// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <jampack/core/array.hpp>
#include <utility>

namespace jampack {

/// Next number of splitmix64 (G. L. Steele, D. Lea and C. H. Flood, OOPSLA 2014): the same on every machine,
/// which the distributions of the standard library are not.
inline std::uint64_t splitmix(std::uint64_t& state) {
  std::uint64_t z = (state += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

/// Puts `items` into a random order, every one as likely as any other.
template <class T>
void shuffle(Array<T>& items, std::uint64_t& state) {
  for (Index i = items.size() - 1; i > 0; --i)
    std::swap(items[i], items[static_cast<Index>(splitmix(state) % static_cast<std::uint64_t>(i + 1))]);
}

}  // namespace jampack
