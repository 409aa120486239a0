// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/io/number.hpp>
#include <limits>
#include <string>

namespace jampack {

/// The values a numeric option may take: an interval with or without its ends. NaN and infinity lie in none.
struct OptionRange {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  bool lower_included = false;
  bool upper_included = false;

  /// Compared in long double, so that a large whole number is not rounded on the way.
  template <Number T>
  bool contains(T value) const {
    const auto number = static_cast<long double>(value);
    const bool above = lower_included ? number >= lower : number > lower;
    const bool below = upper_included ? number <= upper : number < upper;
    return above && below;
  }

  /// As in "must be <text>".
  std::string text() const {
    const bool has_lower = lower > -std::numeric_limits<double>::infinity();
    const bool has_upper = upper < std::numeric_limits<double>::infinity();
    std::string text;
    if (has_lower) text += (lower_included ? "at least " : "above ") + to_text(lower);
    if (has_lower && has_upper) text += " and ";
    if (has_upper) text += (upper_included ? "at most " : "below ") + to_text(upper);
    return text.empty() ? "finite" : text;
  }
};

/// Any finite number.
inline OptionRange any_number() {
  return {};
}
/// [lower, infinity)
inline OptionRange at_least(double lower) {
  return {.lower = lower, .lower_included = true};
}
/// (lower, infinity)
inline OptionRange above(double lower) {
  return {.lower = lower};
}
/// [lower, upper]
inline OptionRange from_to(double lower, double upper) {
  return {.lower = lower, .upper = upper, .lower_included = true, .upper_included = true};
}
/// [lower, upper)
inline OptionRange from_to_below(double lower, double upper) {
  return {.lower = lower, .upper = upper, .lower_included = true};
}
/// (lower, upper)
inline OptionRange strictly_between(double lower, double upper) {
  return {.lower = lower, .upper = upper};
}

}  // namespace jampack
