// SPDX-License-Identifier: MIT
#pragma once

#include <concepts>
#include <jampack/core/array.hpp>
#include <jampack/geometry/ball.hpp>

namespace jampack {

/// Two balls, first < second.
struct BallPair {
  Index first = 0;
  Index second = 0;
  friend bool operator==(const BallPair&, const BallPair&) = default;
  friend auto operator<=>(const BallPair&, const BallPair&) = default;
};

/// A broad phase answers which pairs of balls may be closer than `reach` (surface to surface): a list in
/// ascending order, without repetition, holding every such pair and possibly more. It may remember earlier
/// calls; its answer stays valid until the next one.
template <class T, int Dim>
concept BroadPhase = requires(T& broad_phase, const Balls<Dim>& balls, double reach) {
  { broad_phase.pairs(balls, reach) } -> std::convertible_to<const Array<BallPair>&>;
};

}  // namespace jampack
