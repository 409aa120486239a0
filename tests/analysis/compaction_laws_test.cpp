// SPDX-License-Identifier: MIT
#include <cmath>
#include <jampack/analysis/coordination_law.hpp>
#include <jampack/analysis/heckel_secondi_law.hpp>
#include <jampack/analysis/micromechanical_law.hpp>
#include <jampack/analysis/small_strain_law.hpp>
#include <jampack/analysis/sphericity_law.hpp>
#include <limits>
#include <numbers>

#include "../catch.hpp"

using namespace jampack;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

template <int Dim>
MicromechanicalLaw<Dim> law() {
  if constexpr (Dim == 3) {
    return paper_micromechanical_law;
  } else {
    return {.phi0 = 0.82, .phi_max = 0.99, .z0 = 3.1, .psi = 5.1, .gamma = 4.0, .contact_stiffness = 0.37};
  }
}

}  // namespace

TEMPLATE_TEST_CASE_SIG("The micromechanical law starts at zero, increases and diverges at phi_max", "",
                       ((int Dim), Dim), 2, 3) {
  const auto p = law<Dim>();
  CHECK(p(p.phi0) == 0);
  CHECK(p(p.phi_max) == std::numeric_limits<double>::infinity());
  const int n = 2000;
  double last = 0;
  for (int i = 1; i < n; ++i) {
    const double now = p(p.phi0 + (p.phi_max - p.phi0) * i / n);
    REQUIRE(now > last);
    last = now;
  }
  // The divergence is logarithmic: each further decade of phi_max - phi adds the same pressure.
  const auto at_gap = [&](double gap) { return p(p.phi_max - gap * (p.phi_max - p.phi0)); };
  CHECK_THAT((at_gap(1e-9) - at_gap(1e-8)) / (at_gap(1e-8) - at_gap(1e-7)), WithinRel(1.0, 1e-5));
}

TEMPLATE_TEST_CASE_SIG("Near jamming P/P_SD = 1 + (psi/Z0) sqrt(phi - phi0) + O(phi - phi0)", "",
                       ((int Dim), Dim), 2, 3) {
  const auto p = law<Dim>();
  const auto small = p.small_strain();
  CHECK(small(p.phi0) == 0);
  const double slope = p.psi / p.z0;
  double last_remainder = 0;
  for (const double excess : {1e-4, 1e-6, 1e-8}) {
    const double phi = p.phi0 + excess;
    const double ratio = p(phi) / small(phi);
    CHECK_THAT(ratio, WithinRel(1.0, 1.01 * slope * std::sqrt(excess)));
    // What remains after the first-order term shrinks like phi - phi0, with a constant of order one.
    const double remainder = (ratio - 1 - slope * std::sqrt(excess)) / excess;
    CHECK(std::abs(remainder) < 20);
    if (excess == 1e-6) CHECK_THAT(remainder, WithinRel(last_remainder, 0.2));
    last_remainder = remainder;
  }
}

TEST_CASE("phi dP/dphi vanishes like sqrt(phi - phi0) for spheres and is finite for disks") {
  const auto bulk_modulus = [](const auto& p, double excess) {
    const double step = 1e-3 * excess, phi = p.phi0 + excess;
    return phi * (p(phi + step) - p(phi - step)) / (2 * step);
  };
  const auto spheres = law<3>();
  for (const double excess : {1e-7, 1e-8, 1e-9}) {
    // d/dphi of 2/(3 pi Gamma^(3/2)) Z0 phi0 (excess/phi0)^(3/2)
    const double expected = spheres.z0 / (std::numbers::pi * std::pow(spheres.gamma, 1.5)) * spheres.phi0 *
                            std::sqrt(excess / spheres.phi0);
    CHECK_THAT(bulk_modulus(spheres, excess),
               WithinRel(expected, 4 * spheres.psi / spheres.z0 * std::sqrt(excess)));
  }
  const auto disks = law<2>();
  for (const double excess : {1e-7, 1e-8, 1e-9}) {
    const double expected =
        disks.contact_stiffness * disks.z0 * disks.phi0 / (std::numbers::pi * disks.gamma);
    CHECK_THAT(bulk_modulus(disks, excess),
               WithinRel(expected, 4 * disks.psi / disks.z0 * std::sqrt(excess)));
  }
}

TEST_CASE("The laws give the paper's figures at phi = 0.9") {
  auto p = paper_micromechanical_law;
  CHECK_THAT(p(0.9), WithinAbs(0.300, 1e-3));
  p.phi0 = 0.51;
  CHECK_THAT(p(0.9), WithinAbs(0.277, 1e-3));
  CHECK_THAT(paper_heckel_secondi_law(0.9), WithinAbs(0.295, 1e-3));
}

TEST_CASE("The printed sign of psi would make the pressure negative") {
  auto p = paper_micromechanical_law;
  // -psi is no law: z0 and psi describe a coordination number that grows.
  p.psi = -p.psi;
  CHECK_THROWS_AS(p(0.7), InvalidInput);
  CHECK(p.z0 + p.psi * std::sqrt(0.67 - p.phi0) < 0);
}

TEST_CASE("The law is P = phi Z sigma_l / pi with Hertz's contact stress at small strain") {
  // Built again from its pieces, not from its own formula.
  const auto p = paper_micromechanical_law;
  const double phi = p.phi0 * (1 + 1e-9);
  const double contact_strain = 1e-9 / p.gamma;
  const double contact_stress = 2.0 / 3 * std::pow(contact_strain, 1.5);
  CHECK_THAT(p(phi), WithinRel(phi * p.z0 * contact_stress / std::numbers::pi, 1e-4));
}

TEST_CASE("Z grows from Z0 as a square root") {
  const CoordinationLaw z{.phi0 = 0.5, .z0 = 3.5, .psi = 8.5};
  CHECK(z(0.5) == 3.5);
  CHECK_THAT((z(0.9) - 3.5) / (z(0.6) - 3.5), WithinRel(2.0, 1e-12));
  const auto through = coordination_law_through(0.5, 3.5, 0.965, z(0.965));
  CHECK_THAT(through.psi, WithinRel(8.5, 1e-12));
  CHECK_THROWS_AS(coordination_law_through(0.5, 3.5, 0.4, 9), InvalidInput);
}

TEST_CASE("Sphericity is lost as a power law, to about 0.916 at the end") {
  CHECK(paper_sphericity_law(0.5) == 0);
  auto law = paper_sphericity_law;
  law.phi0 = 0.51;
  CHECK_THAT(1 - law(0.965), WithinAbs(0.916, 5e-4));
  CHECK_THAT(paper_sphericity_law(0.9) / paper_sphericity_law(0.6), WithinRel(std::pow(4, 2.5), 1e-12));
}

TEST_CASE("Laws refuse what they do not describe") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refuses = [&](const auto& any_law, double below, double above) {
    CHECK_THROWS_AS(any_law(below), InvalidInput);
    CHECK_THROWS_AS(any_law(nan), InvalidInput);
    CHECK_THROWS_AS(any_law(above), InvalidInput);
  };
  refuses(paper_micromechanical_law, 0.49, 0.97);
  refuses(law<2>(), 0.81, 0.995);
  refuses(paper_heckel_secondi_law, 0.49, 0.97);
  const double inf = std::numeric_limits<double>::infinity();
  refuses(paper_micromechanical_law.small_strain(), 0.49, inf);
  refuses(law<2>().small_strain(), 0.81, inf);
  refuses(paper_micromechanical_law.coordination(), 0.49, inf);
  refuses(paper_sphericity_law, 0.49, inf);

  auto impossible = paper_micromechanical_law;
  impossible.gamma = 0;
  CHECK_THROWS_AS(impossible(0.6), InvalidInput);
  impossible = paper_micromechanical_law;
  impossible.phi_max = 0.4;
  CHECK_THROWS_AS(impossible(0.6), InvalidInput);
  CHECK_THROWS_AS((HeckelSecondiLaw{.phi0 = 0.5, .phi_max = 0.9, .amplitude = nan}(0.6)), InvalidInput);
}
