// SPDX-License-Identifier: MIT
#include <cmath>
#include <jampack/analysis/compaction_fits.hpp>
#include <jampack/analysis/micromechanical_law.hpp>
#include <jampack/packing/random.hpp>
#include <limits>
#include <numbers>

#include "../catch.hpp"

using namespace jampack;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

/// A standard normal number (Box-Muller), the same on every platform.
double normal(RandomSource& random) {
  return std::sqrt(-2 * std::log(1 - random.unit())) * std::cos(2 * std::numbers::pi * random.unit());
}

Array<double> densities(Index n, double from, double to) {
  Array<double> phi;
  for (Index i = 0; i < n; ++i)
    phi.push_back(from + (to - from) * static_cast<double>(i + 1) / static_cast<double>(n));
  return phi;
}

template <class Law>
Array<double> noisy(const Array<double>& phi, const Law& law, double noise, RandomSource& random) {
  Array<double> y;
  for (const double p : phi) y.push_back(law(p) + noise * normal(random));
  return y;
}

/// Over many noisy samples: the estimates scatter about the truth as much as their standard errors say.
/// Each of the two checks fails by chance about once in 10^4 choices of the seed.
struct Scatter {
  double n = 0, sum = 0, square = 0, claimed = 0;

  void add(const Estimate& estimate) {
    n += 1;
    sum += estimate.value;
    square += estimate.value * estimate.value;
    claimed += estimate.standard_error * estimate.standard_error;
  }
  void check(double truth) const {
    const double mean = sum / n;
    const double deviation = std::sqrt((square - n * mean * mean) / (n - 1));
    CHECK_THAT(mean, WithinAbs(truth, 4 * deviation / std::sqrt(n)));
    CHECK_THAT(std::sqrt(claimed / n), WithinRel(deviation, 4 / std::sqrt(2 * n)));
  }
};

constexpr int n_samples = 400;

}  // namespace

TEST_CASE("Exact data give the parameters back") {
  RandomSource unused(1);
  const auto phi = densities(30, 0.5, 0.95);

  const auto heckel = fit_heckel_secondi(phi, noisy(phi, paper_heckel_secondi_law, 0, unused), 0.5);
  CHECK_THAT(heckel.amplitude.value, WithinRel(0.15, 1e-9));
  CHECK_THAT(heckel.phi_max.value, WithinRel(0.965, 1e-9));
  CHECK_THAT(heckel.r_squared, WithinAbs(1.0, 1e-12));
  CHECK(heckel.n_points == 30);
  CHECK_THAT(heckel.law()(0.9), WithinRel(paper_heckel_secondi_law(0.9), 1e-9));

  const CoordinationLaw z{.phi0 = 0.5, .z0 = 3.5, .psi = 8.5};
  const auto coordination = fit_coordination(phi, noisy(phi, z, 0, unused), 0.5, 3.5);
  CHECK_THAT(coordination.free.prefactor.value, WithinRel(8.5, 1e-9));
  CHECK_THAT(coordination.free.exponent.value, WithinRel(0.5, 1e-9));
  CHECK_THAT(coordination.psi.slope.value, WithinRel(8.5, 1e-12));
  CHECK_THAT(coordination.law()(0.7), WithinRel(z(0.7), 1e-12));

  const auto sphericity = fit_sphericity(phi, noisy(phi, paper_sphericity_law, 0, unused), 0.5);
  CHECK_THAT(sphericity.power.prefactor.value, WithinRel(0.6, 1e-9));
  CHECK_THAT(sphericity.power.exponent.value, WithinRel(2.5, 1e-9));
  CHECK_THAT(sphericity.law()(0.8), WithinRel(paper_sphericity_law(0.8), 1e-9));

  const auto contact =
      fit_contact_strain(phi,
                         noisy(
                             phi, [](double p) { return std::log(p / 0.5) / 4.4; }, 0, unused),
                         0.5, 0.2);
  CHECK_THAT(contact.gamma.value, WithinRel(4.4, 1e-12));
}

TEST_CASE("Noisy data give the parameters back within the standard errors claimed") {
  RandomSource random(20240521);
  const auto phi = densities(40, 0.5, 0.94);
  const CoordinationLaw z{.phi0 = 0.5, .z0 = 3.5, .psi = 8.5};
  Scatter amplitude, phi_max, prefactor, exponent, psi, loss, beta, gamma;
  for (int sample = 0; sample < n_samples; ++sample) {
    const auto heckel = fit_heckel_secondi(phi, noisy(phi, paper_heckel_secondi_law, 2e-3, random), 0.5);
    amplitude.add(heckel.amplitude);
    phi_max.add(heckel.phi_max);
    CHECK(heckel.r_squared > 0.999);
    const auto coordination = fit_coordination(phi, noisy(phi, z, 0.05, random), 0.5, 3.5);
    prefactor.add(coordination.free.prefactor);
    exponent.add(coordination.free.exponent);
    psi.add(coordination.psi.slope);
    const auto sphericity = fit_sphericity(phi, noisy(phi, paper_sphericity_law, 1e-3, random), 0.5);
    loss.add(sphericity.power.prefactor);
    beta.add(sphericity.power.exponent);
    gamma.add(fit_contact_strain(phi,
                                 noisy(
                                     phi, [](double p) { return std::log(p / 0.5) / 4.4; }, 1e-3, random),
                                 0.5, 0.3)
                  .gamma);
  }
  amplitude.check(0.15);
  phi_max.check(0.965);
  prefactor.check(8.5);
  exponent.check(0.5);
  psi.check(8.5);
  loss.check(0.6);
  beta.check(2.5);
  gamma.check(4.4);
}

TEST_CASE("Log-log fit: relative noise, standard errors, R^2 of the logarithms") {
  RandomSource random(5);
  Scatter prefactor, exponent;
  for (int sample = 0; sample < n_samples; ++sample) {
    Array<double> x, y;
    for (int i = 0; i < 30; ++i) {
      x.push_back(std::pow(10.0, -4 + i * 0.1));
      y.push_back(3 * std::pow(x.back(), 1.5) * std::exp(0.05 * normal(random)));
    }
    const auto fit = log_log_fit(x, y);
    prefactor.add(fit.prefactor);
    exponent.add(fit.exponent);
    CHECK(fit.r_squared > 0.99);
    CHECK(fit.n_points == 30);
  }
  prefactor.check(3);
  exponent.check(1.5);
}

TEST_CASE("R^2 is what it says: by hand for a line through the origin") {
  // x = 1, 2, 3; y = 1, 2, 6: slope 23/14, residual sum written out below.
  const auto fit = slope_fit({1, 2, 3}, {1, 2, 6});
  const double slope = 23.0 / 14;
  const double residual =
      (1 - slope) * (1 - slope) + (2 - 2 * slope) * (2 - 2 * slope) + (6 - 3 * slope) * (6 - 3 * slope);
  CHECK_THAT(fit.slope.value, WithinRel(slope, 1e-12));
  CHECK_THAT(fit.slope.standard_error, WithinRel(std::sqrt(residual / 2 / 14), 1e-12));
  CHECK_THAT(fit.r_squared, WithinRel(1 - residual / 14, 1e-12));
}

TEST_CASE("The fits do not depend on the unit of pressure") {
  RandomSource random(3);
  const auto phi = densities(40, 0.5, 0.94);
  const auto pressure = noisy(phi, paper_heckel_secondi_law, 2e-3, random);
  const auto here = fit_heckel_secondi(phi, pressure, 0.5);
  for (const double unit : {1e-9, 1e9}) {
    Array<double> scaled;
    for (const double p : pressure) scaled.push_back(unit * p);
    const auto there = fit_heckel_secondi(phi, scaled, 0.5);
    CHECK_THAT(there.amplitude.value, WithinRel(unit * here.amplitude.value, 1e-8));
    CHECK_THAT(there.phi_max.value, WithinRel(here.phi_max.value, 1e-8));
    CHECK_THAT(there.phi_max.standard_error, WithinRel(here.phi_max.standard_error, 1e-6));
  }
}

TEST_CASE("Heckel-Secondi fitted to the micromechanical law comes near the paper's constants") {
  // The paper fits A = 0.15 and phi_max = 0.965 to data that its own law describes with phi_max = 0.965.
  RandomSource unused(1);
  const auto phi = densities(45, 0.5, 0.955);
  const auto fit = fit_heckel_secondi(phi, noisy(phi, paper_micromechanical_law, 0, unused), 0.5);
  CHECK_THAT(fit.phi_max.value, WithinAbs(0.965, 0.01));
  CHECK_THAT(fit.amplitude.value, WithinAbs(0.15, 0.02));
  // No other pair of constants is better: brute force over phi_max, A being linear.
  const auto misfit = [&](double amplitude, double phi_max) {
    double sum = 0;
    for (const double p : phi)
      sum += std::pow(amplitude * HeckelSecondiLaw{0.5, phi_max, 1}(p)-paper_micromechanical_law(p), 2);
    return sum;
  };
  const double least = misfit(fit.amplitude.value, fit.phi_max.value);
  CHECK(least > 1e-6);  // it is another law
  for (double phi_max = 0.9551; phi_max < 1.2; phi_max += 1e-4) {
    double model_model = 0, model_data = 0;
    for (const double p : phi) {
      const double unit = HeckelSecondiLaw{0.5, phi_max, 1}(p);
      model_model += unit * unit;
      model_data += unit * paper_micromechanical_law(p);
    }
    CHECK(misfit(model_data / model_model, phi_max) >= least * (1 - 1e-12));
  }
}

TEST_CASE("Gamma is fitted to small strains only") {
  Array<double> phi{0.49, 0.5}, contact{0.3, 0.3};  // before jamming: ignored
  for (int i = 1; i <= 20; ++i) {
    const double strain = 0.01 * i;
    phi.push_back(0.5 * std::exp(strain));
    contact.push_back(strain <= 0.1 ? strain / 4.4 : 1.0);
  }
  const auto fit = fit_contact_strain(phi, contact, 0.5, 0.1 + 1e-9);
  CHECK_THAT(fit.gamma.value, WithinRel(4.4, 1e-12));
  CHECK(fit.n_points == 10);
}

TEST_CASE("Too few points and useless data are refused") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(fit_heckel_secondi({0.6, 0.7}, {0.1, 0.2}, 0.5), InvalidInput);
  CHECK_THROWS_AS(fit_heckel_secondi({0.4, 0.6, 0.7, 0.8}, {0, 0.1, 0.2, 0.3}, 0.5), InvalidInput);
  CHECK_THROWS_AS(fit_heckel_secondi({0.6, 0.7, 0.8}, {0.1, nan, 0.3}, 0.5), InvalidInput);
  CHECK_THROWS_AS(fit_heckel_secondi({0.6, 0.7, 0.8}, {0.1, 0.3}, 0.5), InvalidInput);
  CHECK_THROWS_AS(fit_coordination({0.4, 0.5, 0.6, 0.7}, {1, 3.5, 4, 5}, 0.5, 3.5), InvalidInput);
  CHECK_THROWS_AS(fit_contact_strain({0.51}, {0.01}, 0.5), InvalidInput);
  CHECK_THROWS_AS(fit_contact_strain({0.51, 0.52, 0.53}, {-0.01, -0.02, -0.03}, 0.5), InvalidInput);
  CHECK_THROWS_AS(log_log_fit({1, 2}, {1, 2}), InvalidInput);
  CHECK_THROWS_AS(log_log_fit({1, 2, 0}, {1, 2, 3}), InvalidInput);
  CHECK_THROWS_AS(power_law_fit({1, 2, -1}, {1, 2, 3}), InvalidInput);
  CHECK_THROWS_AS(slope_fit({1}, {1}), InvalidInput);
  CHECK_THROWS_AS(slope_fit({0, 0, 0}, {1, 2, 3}), NotConverged);
  CHECK_THROWS_AS(log_log_fit({2, 2, 2, 2}, {1, 2, 3, 4}), NotConverged);
  // A straight line bends towards no phi_max.
  CHECK_THROWS_AS(fit_heckel_secondi({0.6, 0.7, 0.8, 0.9}, {0.1, 0.2, 0.3, 0.4}, 0.5), NotConverged);
}
