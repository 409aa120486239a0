// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/detection/broad_phase.hpp>

namespace jampack {

/// Every pair is looked at every time: the oracle of the other broad phases, and good enough for few balls.
template <int Dim>
class BruteForce {
 public:
  /// Exactly the pairs whose surfaces are at most `reach` (length) apart.
  const Array<BallPair>& pairs(const Balls<Dim>& balls, double reach) {
    pairs_.clear();
    for (Index i = 0; i < balls.size(); ++i)
      for (Index j = i + 1; j < balls.size(); ++j) {
        const double distance = 0.5 * (balls.diameter[i] + balls.diameter[j]) + reach;
        if ((balls.position[i] - balls.position[j]).squaredNorm() <= distance * distance)
          pairs_.push_back({i, j});
      }
    return pairs_;
  }

 private:
  Array<BallPair> pairs_;
};

static_assert(BroadPhase<BruteForce<2>, 2> && BroadPhase<BruteForce<3>, 3>);

}  // namespace jampack
