// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <jampack/analysis/least_squares.hpp>
#include <jampack/core/array.hpp>
#include <jampack/core/error.hpp>

namespace jampack {

/// y = prefactor x^exponent.
struct PowerLawFit {
  Estimate prefactor, exponent;
  double r_squared;  ///< in the quantity that was fitted: y, or ln y
  Index n_points;
};

/// Straight line through ln y against ln x: every point counts by its relative error. Throws InvalidInput for
/// fewer than three points or an x or y that is not positive, NotConverged when all x are the same.
inline PowerLawFit log_log_fit(const Array<double>& x, const Array<double>& y) {
  require(x.size() == y.size(), "log_log_fit: x and y must have the same length");
  Array<double> log_x, log_y;
  for (Index i = 0; i < x.size(); ++i) {
    require(x[i] > 0 && y[i] > 0, "log_log_fit: x and y must be positive");
    log_x.push_back(std::log(x[i]));
    log_y.push_back(std::log(y[i]));
  }
  const auto line = [](double at, const Eigen::Vector2d& p, Eigen::Vector2d& gradient) {
    gradient << 1, at;
    return p.dot(gradient);
  };
  const auto fit = least_squares<2>(log_x, log_y, line, Eigen::Vector2d(0, 1));
  const auto log_prefactor = fit.estimate(0);
  const double prefactor = std::exp(log_prefactor.value);
  return {
      {prefactor, prefactor * log_prefactor.standard_error}, fit.estimate(1), fit.r_squared, fit.n_points};
}

/// The same law fitted to y itself: every point counts by its absolute error, y may be zero or negative at
/// some points, and small x weigh little. Starts from the log-log fit of the points with y > 0. Throws
/// InvalidInput for fewer than three points (with y > 0), or an x that is not positive; NotConverged as
/// least_squares.
inline PowerLawFit power_law_fit(const Array<double>& x, const Array<double>& y) {
  require(x.size() == y.size(), "power_law_fit: x and y must have the same length");
  Array<double> positive_x, positive_y;
  for (Index i = 0; i < x.size(); ++i) {
    require(x[i] > 0, "power_law_fit: x must be positive");
    if (!(y[i] > 0)) continue;
    positive_x.push_back(x[i]);
    positive_y.push_back(y[i]);
  }
  const PowerLawFit start = log_log_fit(positive_x, positive_y);
  const auto power = [](double at, const Eigen::Vector2d& p, Eigen::Vector2d& gradient) {
    const double unit = std::pow(at, p[1]);
    gradient << unit, p[0] * unit * std::log(at);
    return p[0] * unit;
  };
  const auto fit =
      least_squares<2>(x, y, power, Eigen::Vector2d(start.prefactor.value, start.exponent.value));
  return {fit.estimate(0), fit.estimate(1), fit.r_squared, fit.n_points};
}

/// y = slope x through the origin.
struct SlopeFit {
  Estimate slope;
  double r_squared;
  Index n_points;
};

/// Throws InvalidInput for fewer than two points, NotConverged when all x are zero.
inline SlopeFit slope_fit(const Array<double>& x, const Array<double>& y) {
  using Slope = Eigen::Matrix<double, 1, 1>;
  const auto line = [](double at, const Slope& p, Slope& gradient) {
    gradient[0] = at;
    return p[0] * at;
  };
  const auto fit = least_squares<1>(x, y, line, Slope(0.0));
  return {fit.estimate(0), fit.r_squared, fit.n_points};
}

}  // namespace jampack
