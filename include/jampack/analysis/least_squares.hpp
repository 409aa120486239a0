// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <jampack/core/array.hpp>
#include <jampack/core/error.hpp>
#include <limits>
#include <string>

namespace jampack {

/// A fitted number and its standard error.
struct Estimate {
  double value;
  double standard_error;
};

/// Least-squares fit of n_parameters numbers. Standard errors assume independent residuals of one unknown
/// variance, s^2 = sum r^2 / (n_points - n_parameters): covariance s^2 (J^T J)^-1.
template <int n_parameters>
struct LeastSquaresFit {
  Eigen::Matrix<double, n_parameters, 1> parameters;
  Eigen::Matrix<double, n_parameters, n_parameters> covariance;
  double r_squared;  ///< 1 - sum r^2 / sum (y - <y>)^2, against a constant also for fits through the origin
  Index n_points;

  Estimate estimate(int k) const { return {parameters[k], std::sqrt(covariance(k, k))}; }
};

/// Fits y_i ~ model(x_i, parameters) by Levenberg-Marquardt with Marquardt's scaling.
///
/// `double model(double x, const Parameters&, Parameters& gradient)` returns the value and writes its
/// derivatives; a value that is not finite marks parameters out of bounds, and the step there is refused. The
/// start must be in bounds. Stops when the residual is orthogonal to every column of the Jacobian (cosine
/// 1e-10), or when no step of relative size 1e-12 lowers the sum of squares. Throws InvalidInput for arrays
/// of different length, numbers that are not finite or fewer than n_parameters + 1 points, NotConverged when
/// 200 steps do not settle it or the data do not determine every parameter.
template <int n_parameters, class Model>
LeastSquaresFit<n_parameters> least_squares(const Array<double>& x, const Array<double>& y,
                                            const Model& model,
                                            Eigen::Matrix<double, n_parameters, 1> parameters) {
  using Parameters = Eigen::Matrix<double, n_parameters, 1>;
  using Normal = Eigen::Matrix<double, n_parameters, n_parameters>;
  const Index n = x.size();
  require(n == y.size(), "least_squares: x and y must have the same length");
  require(n > n_parameters, "least_squares: " + std::to_string(n) + " points are too few for " +
                                std::to_string(n_parameters) + " parameters and their errors");
  double mean = 0;
  for (Index i = 0; i < n; ++i) {
    require(std::isfinite(x[i]) && std::isfinite(y[i]), "least_squares: the data must be finite");
    mean += y[i] / static_cast<double>(n);
  }

  struct Linearised {
    double cost = 0;
    Normal normal = Normal::Zero();
    Parameters slope = Parameters::Zero();
  };
  const auto linearise = [&](const Parameters& at) {
    Linearised result;
    Parameters gradient = Parameters::Zero();
    for (Index i = 0; i < n; ++i) {
      const double residual = y[i] - model(x[i], at, gradient);
      if (!std::isfinite(residual) || !gradient.allFinite()) {
        result.cost = std::numeric_limits<double>::infinity();
        break;
      }
      result.cost += residual * residual;
      result.slope += residual * gradient;
      result.normal += gradient * gradient.transpose();
    }
    return result;
  };

  Linearised here = linearise(parameters);
  require(std::isfinite(here.cost), "least_squares: the model is not finite at the starting parameters");
  double damping = 1e-3;
  bool converged = false;
  for (int step = 0; step < 200 && !converged; ++step) {
    const Parameters scale = here.normal.diagonal().cwiseMax(1e-300).cwiseSqrt();
    const double cosine = (here.slope.cwiseQuotient(scale)).cwiseAbs().maxCoeff() / std::sqrt(here.cost);
    if (here.cost == 0 || cosine < 1e-10) {
      converged = true;
      break;
    }
    // Solved in scaled unknowns, where the diagonal is 1 + damping.
    Normal scaled = scale.cwiseInverse().asDiagonal() * here.normal * scale.cwiseInverse().asDiagonal();
    scaled.diagonal().array() += damping;
    const Parameters move = scaled.fullPivLu().solve(here.slope.cwiseQuotient(scale)).cwiseQuotient(scale);
    const Parameters trial = parameters + move;
    const Linearised there = linearise(trial);
    if (there.cost < here.cost) {
      parameters = trial;
      here = there;
      damping = std::max(damping / 10, 1e-14);
    } else {
      converged = (move.cwiseAbs().array() <= 1e-12 * parameters.cwiseAbs().array()).all();
      damping *= 10;
    }
  }
  if (!converged)
    throw NotConverged("least_squares: no minimum found in 200 steps; is the model the right one?");

  const Parameters scale = here.normal.diagonal().cwiseSqrt();
  if (!(scale.minCoeff() > 0)) throw NotConverged("least_squares: the data do not determine every parameter");
  const Normal correlation =
      scale.cwiseInverse().asDiagonal() * here.normal * scale.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Normal> modes(correlation);
  if (!(modes.eigenvalues().minCoeff() > 1e-13))
    throw NotConverged("least_squares: the data do not determine every parameter");
  const Normal inverse = scale.cwiseInverse().asDiagonal() * modes.eigenvectors() *
                         modes.eigenvalues().cwiseInverse().asDiagonal() * modes.eigenvectors().transpose() *
                         scale.cwiseInverse().asDiagonal();
  const double variance = here.cost / static_cast<double>(n - n_parameters);
  double spread = 0;
  for (Index i = 0; i < n; ++i) spread += (y[i] - mean) * (y[i] - mean);
  const double r_squared = spread > 0 ? 1 - here.cost / spread : (here.cost == 0 ? 1.0 : 0.0);
  return {parameters, variance * inverse, r_squared, n};
}

}  // namespace jampack
