// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <jampack/core/dimension.hpp>
#include <jampack/geometry/orientation.hpp>
#include <numbers>
#include <random>

namespace jampack {

/// Random numbers that are the same on every platform. std::mt19937_64 is fixed by the standard, the
/// distributions of <random> are not, so they are written out here.
class RandomSource {
 public:
  explicit RandomSource(std::uint64_t seed) : engine_(seed) {}

  /// Uniform in [0, 1): the 53 leading bits of one draw.
  double unit() { return static_cast<double>(engine_() >> 11) * 0x1.0p-53; }

  /// Uniform in [lower, upper).
  double uniform(double lower, double upper) { return lower + (upper - lower) * unit(); }

  /// A rotation uniform over all rotations (K. Shoemake, "Uniform random rotations", Graphics Gems III,
  /// 1992).
  template <int Dim>
  Orientation<Dim> orientation() {
    constexpr double turn = 2.0 * std::numbers::pi;
    if constexpr (Dim == 2) {
      return uniform(0.0, turn);
    } else {
      const double split = unit();
      const double a = uniform(0.0, turn);
      const double b = uniform(0.0, turn);
      const double short_side = std::sqrt(1.0 - split);
      const double long_side = std::sqrt(split);
      return {long_side * std::cos(b), short_side * std::sin(a), short_side * std::cos(a),
              long_side * std::sin(b)};
    }
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace jampack
