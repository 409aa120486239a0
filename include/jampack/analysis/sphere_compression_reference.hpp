// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <jampack/analysis/hertz.hpp>
#include <optional>

namespace jampack {

/// Finite-strain answer for one neo-Hookean sphere between two frictionless plates,
///   psi = mu/2 (tr C - 3 - 2 ln J) + lambda/2 ln^2 J,
/// as F/F_H, the force over Hertz's at the same approach delta of one contact: a converged axisymmetric
/// solution on three meshes that agree to 0.3 %. docs/theory/compaction_laws.md, table 1.
namespace sphere_compression_table {
inline constexpr std::size_t n_rows = 11;
/// delta/d; the first row is Hertz's limit.
inline constexpr std::array<double, n_rows> delta_over_d = {0,    0.0025, 0.005, 0.01, 0.02, 0.03,
                                                            0.05, 0.075,  0.10,  0.15, 0.20};
inline constexpr std::array<double, n_rows> ratio_0495 = {1.0,   1.021, 1.032, 1.048, 1.073, 1.096,
                                                          1.140, 1.198, 1.264, 1.439, 1.715};
inline constexpr std::array<double, n_rows> ratio_03 = {1.0,   1.028, 1.045, 1.068, 1.105, 1.134,
                                                        1.190, 1.257, 1.328, 1.496, 1.732};
}  // namespace sphere_compression_table

namespace detail {

/// Slope at knot i of the quartic through the five knots nearest to it (N >= 5).
template <std::size_t N>
constexpr double five_knot_slope(const std::array<double, N>& x, const std::array<double, N>& y,
                                 std::size_t i) {
  const std::size_t first = i < 2 ? 0 : (i + 3 > N ? N - 5 : i - 2);
  double slope = 0;
  for (std::size_t j = first; j < first + 5; ++j) {
    // Derivative at x[i] of Lagrange's polynomial j.
    double derivative = j == i ? 0 : 1 / (x[j] - x[i]);
    for (std::size_t k = first; k < first + 5; ++k) {
      if (j == i && k != i) derivative += 1 / (x[i] - x[k]);
      if (j != i && k != i && k != j) derivative *= (x[i] - x[k]) / (x[j] - x[k]);
    }
    slope += derivative * y[j];
  }
  return slope;
}

/// Cubic Hermite interpolation with those slopes, for at in [x.front(), x.back()].
template <std::size_t N>
constexpr double hermite(const std::array<double, N>& x, const std::array<double, N>& y, double at) {
  std::size_t i = 0;
  while (i + 2 < N && at > x[i + 1]) ++i;
  const double h = x[i + 1] - x[i];
  const double t = (at - x[i]) / h;
  const double left = five_knot_slope(x, y, i) * h;
  const double right = five_knot_slope(x, y, i + 1) * h;
  const double rise = y[i + 1] - y[i];
  return y[i] + t * (left + t * (3 * rise - 2 * left - right + t * (left + right - 2 * rise)));
}

}  // namespace detail

/// F/F_H at delta/d in [0, 0.20] and poisson 0.495 or 0.3, interpolated (its logarithm, piecewise cubic
/// with a continuous slope) in sqrt(delta/d), in which it is smooth; empty outside this range and for any
/// other poisson. Leaving a row out, the others predict it to 0.3 %, the table's own accuracy.
inline std::optional<double> sphere_compression_ratio(double delta_over_d, double poisson) {
  namespace table = sphere_compression_table;
  if (!(delta_over_d >= 0 && delta_over_d <= table::delta_over_d.back())) return std::nullopt;
  const bool nearly_incompressible = std::abs(poisson - 0.495) < 1e-12;
  if (!nearly_incompressible && !(std::abs(poisson - 0.3) < 1e-12)) return std::nullopt;
  const auto& ratio = nearly_incompressible ? table::ratio_0495 : table::ratio_03;
  std::array<double, table::n_rows> root{}, log_ratio{};
  for (std::size_t i = 0; i < table::n_rows; ++i) {
    root[i] = std::sqrt(table::delta_over_d[i]);
    log_ratio[i] = std::log(ratio[i]);
  }
  return std::exp(detail::hermite(root, log_ratio, std::sqrt(delta_over_d)));
}

/// The force itself, at approach delta of one contact; empty where there is no reference.
inline std::optional<double> sphere_compression_force(const HertzSphere& sphere, double delta) {
  const auto ratio = sphere_compression_ratio(delta / sphere.diameter, sphere.poisson);
  if (!ratio) return std::nullopt;
  return *ratio * hertz_sphere_on_plane(sphere).force(delta);
}

}  // namespace jampack
