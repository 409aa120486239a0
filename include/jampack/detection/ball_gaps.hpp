// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <jampack/core/error.hpp>
#include <jampack/detection/broad_phase.hpp>
#include <jampack/geometry/container.hpp>
#include <string>

namespace jampack {

/// A ball and what it touches or may touch soon: another ball of lower index, or a wall.
template <int Dim>
struct BallGap {
  Index candidate = 0;                        ///< ball
  Index antagonist = -1;                      ///< ball, or -1 at a wall
  Index wall = -1;                            ///< wall, or -1 between balls
  double gap = 0.0;                           ///< between the surfaces, negative when they overlap; length
  Vector<Dim> normal = Vector<Dim>::UnitX();  ///< unit, from the antagonist or wall to the candidate

  bool at_wall() const { return antagonist < 0; }
};

/// Narrow phase: every gap of at most `reach` (length) replaces what `gaps` held. Ball pairs come first, then
/// walls, each in ascending order. Throws NotConverged when two centres coincide, for then there is no
/// normal.
template <int Dim, BroadPhase<Dim> Broad>
void find_gaps(Broad& broad_phase, const Balls<Dim>& balls, const Container<Dim>& room, double reach,
               Array<BallGap<Dim>>& gaps) {
  gaps.clear();
  for (const BallPair& pair : broad_phase.pairs(balls, reach)) {
    const Vector<Dim> apart = balls.position[pair.second] - balls.position[pair.first];
    const double touching = 0.5 * (balls.diameter[pair.first] + balls.diameter[pair.second]);
    const double squared = apart.squaredNorm();
    if (!(squared <= (touching + reach) * (touching + reach))) continue;
    const double distance = std::sqrt(squared);
    if (!(distance > 1e-12 * touching))
      throw NotConverged("detection: the centres of balls " + std::to_string(pair.first) + " and " +
                         std::to_string(pair.second) +
                         " coincide, so their contact has no normal; start from balls that do not overlap");
    gaps.push_back({pair.second, pair.first, -1, distance - touching, apart / distance});
  }
  for (Index i = 0; i < balls.size(); ++i)
    for (Index w = 0; w < room.n_walls(); ++w) {
      const double gap = room.gap(w, balls.position[i]) - 0.5 * balls.diameter[i];
      if (gap <= reach) gaps.push_back({i, -1, w, gap, room.normal[w]});
    }
}

}  // namespace jampack
