// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <jampack/analysis/elastic_moduli.hpp>
#include <jampack/core/error.hpp>
#include <numbers>

namespace jampack {

/// A cylinder between two rigid plates in plane strain, at small strain; forces are per unit length and
/// delta is the approach at one contact (axis to plate):
///   delta = f (1 - nu^2) / (pi E) [2 ln(4 R / b) - 1],   b^2 = 4 f R (1 - nu^2) / (pi E).
/// A line contact has no compliance of its own: delta depends on what else loads the cylinder, here the
/// opposite plate. K. L. Johnson, Contact Mechanics (1985), eq. 5.58; docs/theory/compaction_laws.md (13).
struct CylinderBetweenPlates {
  double diameter;  ///< > 0
  double young;     ///< > 0
  double poisson;   ///< in (-1, 0.5]

  /// b, half the width of a contact, at force f >= 0.
  double half_width(double f) const {
    require(f >= 0 && std::isfinite(f), "CylinderBetweenPlates: the force must be finite and not negative");
    return std::sqrt(2 * f * diameter / (std::numbers::pi * modulus()));
  }

  /// delta at force f. Throws InvalidInput where b would exceed R, far beyond the theory.
  double approach(double f) const {
    const double ratio = half_width(f) / (diameter / 2);
    require(ratio <= 1, "CylinderBetweenPlates: the force makes the contact wider than the cylinder");
    return diameter / 2 * approach_over_radius(ratio);
  }

  /// f at approach delta >= 0, by safeguarded Newton on b / R. Throws InvalidInput where b would exceed R
  /// (delta > 0.443 R).
  double force(double delta) const {
    const double radius = diameter / 2;
    const double e = modulus();
    const double target = delta / radius;
    require(target >= 0, "CylinderBetweenPlates: the approach must not be negative");
    require(target <= approach_over_radius(1.0),
            "CylinderBetweenPlates: the approach makes the contact wider than the cylinder");
    if (target == 0) return 0;
    // approach_over_radius increases on (0, 1]: the root stays bracketed.
    double low = 0, high = 1, ratio = std::sqrt(target);
    for (int i = 0; i < 200 && high - low > 0; ++i) {
      const double excess = approach_over_radius(ratio) - target;
      (excess > 0 ? high : low) = ratio;
      const double slope = ratio * (std::log(4 / ratio) - 1);
      double next = ratio - excess / slope;
      if (!(next >= low && next <= high)) next = (low + high) / 2;
      if (std::abs(next - ratio) <= 1e-15 * ratio) break;
      ratio = next;
    }
    return std::numbers::pi * e * radius * ratio * ratio / 4;
  }

 private:
  double modulus() const {
    require(diameter > 0 && std::isfinite(diameter), "CylinderBetweenPlates: the diameter must be positive");
    return half_space_modulus(young, poisson);
  }
  static double approach_over_radius(double half_width_over_radius) {
    const double s = half_width_over_radius;
    return s > 0 ? s * s / 4 * (2 * std::log(4 / s) - 1) : 0.0;
  }
};

}  // namespace jampack
