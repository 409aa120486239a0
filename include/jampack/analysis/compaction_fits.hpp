// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <jampack/analysis/coordination_law.hpp>
#include <jampack/analysis/heckel_secondi_law.hpp>
#include <jampack/analysis/least_squares.hpp>
#include <jampack/analysis/power_law_fit.hpp>
#include <jampack/analysis/sphericity_law.hpp>
#include <jampack/core/array.hpp>
#include <jampack/core/error.hpp>
#include <limits>

namespace jampack {

/// The Heckel-Secondi law fitted to a curve: A and phi_max, phi0 given.
struct HeckelSecondiFit {
  double phi0;
  Estimate amplitude, phi_max;
  double r_squared;
  Index n_points;

  HeckelSecondiLaw law() const { return {phi0, phi_max.value, amplitude.value}; }
};

/// Fits -A ln[(phi_max - phi) / (phi_max - phi0)] to P/E* on all points given, phi >= phi0. Starts from the
/// best of a range of phi_max, for each of which A is linear. Throws InvalidInput for fewer than three points
/// or a phi below phi0, NotConverged when the curve does not bend towards a phi_max.
inline HeckelSecondiFit fit_heckel_secondi(const Array<double>& phi, const Array<double>& pressure,
                                           double phi0) {
  require(phi.size() == pressure.size(), "fit_heckel_secondi: phi and pressure must have the same length");
  require(phi0 > 0 && phi.size() >= 3, "fit_heckel_secondi: needs phi0 > 0 and at least three points");
  double densest = phi0;
  for (const double p : phi) {
    require(p >= phi0 && std::isfinite(p), "fit_heckel_secondi: every phi must be at least phi0");
    densest = std::max(densest, p);
  }
  require(densest > phi0, "fit_heckel_secondi: no point lies above phi0");

  Eigen::Vector2d start;
  double least = std::numeric_limits<double>::infinity();
  for (double margin = 1e-5; margin < 100; margin *= 1.5) {
    const double phi_max = densest + margin * (densest - phi0);
    double model_model = 0, model_data = 0, data_data = 0;
    for (Index i = 0; i < phi.size(); ++i) {
      const double unit = HeckelSecondiLaw{phi0, phi_max, 1}(phi[i]);
      model_model += unit * unit;
      model_data += unit * pressure[i];
      data_data += pressure[i] * pressure[i];
    }
    const double cost = data_data - model_data * model_data / model_model;
    if (cost < least) {
      least = cost;
      start << model_data / model_model, phi_max;
    }
  }
  require(std::isfinite(least), "fit_heckel_secondi: the pressures must be finite");
  const auto law = [&](double at, const Eigen::Vector2d& p, Eigen::Vector2d& gradient) {
    if (!(p[0] > 0) || !(p[1] > densest)) return std::numeric_limits<double>::quiet_NaN();
    const double unit = HeckelSecondiLaw{phi0, p[1], 1}(at);
    gradient << unit, p[0] * (1 / (p[1] - phi0) - 1 / (p[1] - at));
    return p[0] * unit;
  };
  const auto fit = least_squares<2>(phi, pressure, law, start);
  return {phi0, fit.estimate(0), fit.estimate(1), fit.r_squared, fit.n_points};
}

/// Growth of the coordination number beyond jamming, phi0 and Z0 given.
struct CoordinationFit {
  double phi0, z0;
  PowerLawFit free;  ///< Z - Z0 = prefactor (phi - phi0)^exponent
  SlopeFit psi;      ///< with the exponent 1/2 of the law

  CoordinationLaw law() const { return {phi0, z0, psi.slope.value}; }
};

/// Fits the points with phi > phi0. Throws InvalidInput for fewer than three of them above both phi0 and Z0.
inline CoordinationFit fit_coordination(const Array<double>& phi, const Array<double>& z, double phi0,
                                        double z0) {
  require(phi.size() == z.size(), "fit_coordination: phi and z must have the same length");
  Array<double> excess, root, growth;
  for (Index i = 0; i < phi.size(); ++i) {
    if (!(phi[i] > phi0)) continue;
    excess.push_back(phi[i] - phi0);
    root.push_back(std::sqrt(phi[i] - phi0));
    growth.push_back(z[i] - z0);
  }
  return {phi0, z0, power_law_fit(excess, growth), slope_fit(root, growth)};
}

/// Gamma in contact_strain = ln(phi/phi0) / Gamma.
struct ContactStrainFit {
  Estimate gamma;
  double r_squared;
  Index n_points;
};

/// Line through the origin over the points with 0 < ln(phi/phi0) <= largest_strain, the small strains for
/// which the relation is meant. Throws InvalidInput for fewer than two of them, or a slope that is not
/// positive.
inline ContactStrainFit fit_contact_strain(const Array<double>& phi, const Array<double>& contact_strain,
                                           double phi0, double largest_strain = 0.1) {
  require(phi.size() == contact_strain.size(),
          "fit_contact_strain: phi and contact_strain must have the same length");
  require(phi0 > 0 && largest_strain > 0, "fit_contact_strain: phi0 and largest_strain must be positive");
  Array<double> strain, contact;
  for (Index i = 0; i < phi.size(); ++i) {
    const double e = std::log(phi[i] / phi0);
    if (!(e > 0 && e <= largest_strain)) continue;
    strain.push_back(e);
    contact.push_back(contact_strain[i]);
  }
  const SlopeFit fit = slope_fit(strain, contact);
  const double slope = fit.slope.value;
  require(slope > 0, "fit_contact_strain: the contact strain does not grow with the strain");
  return {{1 / slope, fit.slope.standard_error / (slope * slope)}, fit.r_squared, fit.n_points};
}

/// Loss of sphericity beyond jamming, phi0 given: prefactor A and exponent beta.
struct SphericityFit {
  double phi0;
  PowerLawFit power;

  SphericityLaw law() const { return {phi0, power.prefactor.value, power.exponent.value}; }
};

/// Fits sphericity_loss = rho0 - rho on the points with phi > phi0; throws as power_law_fit.
inline SphericityFit fit_sphericity(const Array<double>& phi, const Array<double>& sphericity_loss,
                                    double phi0) {
  require(phi.size() == sphericity_loss.size(),
          "fit_sphericity: phi and sphericity_loss must have the same length");
  Array<double> excess, loss;
  for (Index i = 0; i < phi.size(); ++i) {
    if (!(phi[i] > phi0)) continue;
    excess.push_back(phi[i] - phi0);
    loss.push_back(sphericity_loss[i]);
  }
  return {phi0, power_law_fit(excess, loss)};
}

}  // namespace jampack
