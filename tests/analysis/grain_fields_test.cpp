// SPDX-License-Identifier: MIT
#include <cmath>
#include <jampack/analysis/field_statistics.hpp>
#include <jampack/analysis/grain_shape.hpp>
#include <jampack/analysis/von_mises.hpp>
#include <jampack/core/dimension.hpp>
#include <numbers>

#include "../catch.hpp"

using namespace jampack;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

/// A density sampled at equal steps, each point weighted by it.
template <class Density>
WeightedField sampled(Density density, double to, Index n) {
  WeightedField field;
  for (Index i = 0; i < n; ++i) {
    const double x = (static_cast<double>(i) + 0.5) * to / static_cast<double>(n);
    field.add(x, density(x));
  }
  return field;
}

}  // namespace

TEST_CASE("Sphericity and circularity of known shapes") {
  const double pi = std::numbers::pi, r = 1.7;
  CHECK_THAT(sphericity(4 * pi / 3 * r * r * r, 4 * pi * r * r), WithinRel(1.0, 1e-14));
  CHECK_THAT(sphericity(r * r * r, 6 * r * r), WithinRel(std::cbrt(pi / 6), 1e-14));
  // Truncated octahedron of edge 1, the shape of grains that fill space: V = 8 sqrt 2, a = 6 + 12 sqrt 3.
  CHECK_THAT(sphericity(8 * std::sqrt(2.0), 6 + 12 * std::sqrt(3.0)), WithinAbs(0.910, 5e-4));
  CHECK_THAT(circularity(pi * r * r, 2 * pi * r), WithinRel(1.0, 1e-14));
  CHECK_THAT(circularity(r * r, 4 * r), WithinRel(pi / 4, 1e-14));
  CHECK_THAT(roundness<2>(2, 7), WithinRel(circularity(2, 7), 1e-14));
  CHECK_THAT(roundness<3>(2, 9), WithinRel(sphericity(2, 9), 1e-14));
  CHECK_THAT(mean_roundness<2>({1, pi}, {4, 2 * pi}), WithinRel((1 + pi / 4) / 2, 1e-14));
  CHECK_THROWS_AS(sphericity(-1, 1), InvalidInput);
  CHECK_THROWS_AS(circularity(1, 0), InvalidInput);
  CHECK_THROWS_AS(mean_roundness<3>({}, {}), InvalidInput);
  CHECK_THROWS_AS(mean_roundness<3>({1, 1}, {6}), InvalidInput);
}

TEST_CASE("Von Mises stress: uniaxial, pure shear, hydrostatic, turned") {
  Matrix<3> stress = Matrix<3>::Zero();
  stress(0, 0) = -2.5;
  CHECK_THAT(von_mises(stress), WithinRel(2.5, 1e-14));
  Matrix<3> shear = Matrix<3>::Zero();
  shear(0, 1) = shear(1, 0) = 0.7;
  CHECK_THAT(von_mises(shear), WithinRel(std::sqrt(3.0) * 0.7, 1e-14));
  CHECK(von_mises(Matrix<3>(4 * Matrix<3>::Identity())) < 1e-14);
  Matrix<3> turn;
  const double c = std::cos(0.4), s = std::sin(0.4);
  turn << c, -s, 0, s, c, 0, 0, 0, 1;
  const Matrix<3> both = stress + shear + 3 * Matrix<3>::Identity();
  CHECK_THAT(von_mises(Matrix<3>(turn * both * turn.transpose())), WithinRel(von_mises(both), 1e-13));
}

TEST_CASE("Von Mises stress in plane strain needs the stress out of the plane") {
  // Uniaxial stress in the plane, linear elastic: s_zz = nu s_xx, so sqrt(1 - nu + nu^2) s_xx.
  Matrix<2> stress = Matrix<2>::Zero();
  stress(0, 0) = 3;
  const double nu = 0.3;
  CHECK_THAT(von_mises(stress, nu * 3), WithinRel(3 * std::sqrt(1 - nu + nu * nu), 1e-14));
  CHECK(von_mises(Matrix<2>(Matrix<2>::Identity()), 1.0) < 1e-14);
}

TEST_CASE("Moments and density of a field weighted by volume") {
  // Doubling a weight is the same as the point twice.
  const WeightedField once{{1, 3, 3, 5}, {1, 1, 1, 1}}, weighted{{1, 3, 5}, {2, 4, 2}};
  CHECK_THAT(field_moments(once).mean, WithinRel(3.0, 1e-14));
  CHECK_THAT(field_moments(weighted).standard_deviation,
             WithinRel(field_moments(once).standard_deviation, 1e-14));
  CHECK_THAT(normalised_standard_deviation(weighted), WithinRel(std::sqrt(2.0) / 3, 1e-14));
  CHECK(normalised_standard_deviation({{0, 0}, {1, 2}}) == 0);

  const FieldPdf pdf = field_pdf(weighted, 4, 2);  // bins of width 1/2 in value / 3
  CHECK(pdf.bin_width == 0.5);
  CHECK(pdf.centres == Array<double>{0.25, 0.75, 1.25, 1.75});
  CHECK_THAT(pdf.densities[0], WithinRel(0.25 / 0.5, 1e-14));
  CHECK(pdf.densities[1] == 0);
  CHECK_THAT(pdf.densities[2], WithinRel(0.5 / 0.5, 1e-14));
  CHECK_THAT(pdf.densities[3], WithinRel(0.25 / 0.5, 1e-14));
}

TEST_CASE("The density integrates to the fraction within its range and follows a known one") {
  const auto field = sampled([](double x) { return std::exp(-x / 0.7); }, 40, 200000);
  const FieldPdf pdf = field_pdf(field, 60, 3);
  double integral = 0;
  for (Index b = 0; b < 60; ++b) {
    integral += pdf.densities[b] * pdf.bin_width;
    CHECK_THAT(pdf.densities[b], WithinRel(std::exp(-pdf.centres[b]), 1e-2));
  }
  CHECK_THAT(integral, WithinRel(1 - std::exp(-3.0), 1e-3));
  CHECK_THAT(normalised_standard_deviation(field), WithinRel(1.0, 1e-4));
}

TEST_CASE("The tail tells exponential, Gaussian and uniform apart") {
  const auto exponential = sampled([](double x) { return std::exp(-x / 0.7); }, 40, 200000);
  for (const double threshold : {1.0, 2.0}) {
    const FieldTail tail = field_tail(exponential, threshold);
    CHECK_THAT(tail.weight_fraction, WithinRel(std::exp(-threshold), 1e-3));
    CHECK_THAT(tail.mean_excess, WithinRel(1.0, 1e-3));
    CHECK_THAT(tail.shape, WithinRel(2.0, 1e-3));
  }
  const auto gaussian =
      sampled([](double x) { return std::exp(-(x - 3) * (x - 3) / (2 * 0.16)); }, 6, 200000);
  CHECK_THAT(field_tail(gaussian).shape, WithinRel(std::numbers::pi / 2, 1e-3));
  CHECK_THAT(field_tail(gaussian).weight_fraction, WithinRel(0.5, 1e-3));
  CHECK_THAT(field_tail(sampled([](double) { return 1.0; }, 2, 200000)).shape, WithinRel(4.0 / 3, 1e-3));
  CHECK(field_tail(gaussian, 10).shape == 0);
}

TEST_CASE("Impossible fields are refused") {
  const double nan = std::nan("");
  CHECK_THROWS_AS(field_moments({}), InvalidInput);
  CHECK_THROWS_AS(field_moments({{1, 2}, {1}}), InvalidInput);
  CHECK_THROWS_AS(field_moments({{1, nan}, {1, 1}}), InvalidInput);
  CHECK_THROWS_AS(field_moments({{1, 2}, {1, -1}}), InvalidInput);
  CHECK_THROWS_AS(field_moments({{1, 2}, {0, 0}}), InvalidInput);
  CHECK_THROWS_AS(field_pdf({{-1, -2}, {1, 1}}), InvalidInput);
  CHECK_THROWS_AS(field_pdf({{1, 2}, {1, 1}}, 0), InvalidInput);
  CHECK_THROWS_AS(normalised_standard_deviation({{-1, -2}, {1, 1}}), InvalidInput);
}
