// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/core/array.hpp>

namespace jampack {

/// Scalars of which the first begins a cache line: what is read in vectors as long as a line is then read
/// line by line, where vectors across two lines take twice as long.
class AlignedScalars {
 public:
  static constexpr Index per_line = 8;

  /// `n` rounded up to whole lines.
  static constexpr Index padded(Index n) { return (n + per_line - 1) / per_line * per_line; }

  AlignedScalars() = default;
  explicit AlignedScalars(Index n) { resize(n); }

  /// What is new is zero.
  void resize(Index n) { lines_.resize(padded(n) / per_line); }
  double* data() { return lines_.empty() ? nullptr : lines_.data()->value; }
  const double* data() const { return lines_.empty() ? nullptr : lines_.data()->value; }

 private:
  struct alignas(64) Line {
    double value[per_line] = {};
  };
  Array<Line> lines_;
};

}  // namespace jampack
