// SPDX-License-Identifier: MIT
#include <cmath>
#include <numbers>

#include "../catch.hpp"
#include "blocks.hpp"

using namespace jampack;
using namespace jampack_tests;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

constexpr double pi = std::numbers::pi;

/// Unit square, its inner lines bent, so that no symmetry hides an error.
Vector<2> bent(double s, double t) {
  const double bump = 0.05 * std::sin(2 * pi * s) * std::sin(2 * pi * t);
  return {s + bump, t + bump / 2};
}

/// Smallest and largest pressure of the cells, and the force on the top, of a block pressed to `stretch`
/// between smooth walls.
template <class Element>
std::array<double, 3> oedometer(double poisson, double stretch) {
  const Solid<2, Element, NeoHookean> solid(block_mesh<Element>(4, 4, bent), {1, poisson, 1});
  Eigen::VectorXd x = solid.reference;
  std::set<Index> held;
  for (Index i = 0; i < x.size(); i += 2) {
    if (std::abs(x[i] - 0.5) > 0.5 - 1e-9) held.insert(i);
    if (std::abs(x[i + 1] - 0.5) > 0.5 - 1e-9) held.insert(i + 1);
    x[i + 1] *= stretch;
  }
  const double size = 0.02 * (1 - stretch);
  for (Index i = 0; i < x.size(); ++i)
    if (!held.count(i)) x[i] += size * std::sin(static_cast<double>(i * i));
  x = solid.equilibrium(x, Eigen::VectorXd::Zero(x.size()), held, 1e-10);
  const Eigen::VectorXd f = solid.force(x);
  std::array<double, 3> result{1e300, -1e300, 0};
  for (Index i = 0; i < x.size(); i += 2)
    if (solid.reference[i + 1] > 1 - 1e-9) result[2] += f[i + 1];
  for (const auto& cell : solid.cells)
    Element::for_each_point(cell, solid.material, solid.gather(cell, x),
                            [&](double, const Matrix<2>& stress, double) {
                              result[0] = std::min(result[0], -stress.trace() / 2);
                              result[1] = std::max(result[1], -stress.trace() / 2);
                            });
  return result;
}

/// Errors of a manufactured nearly incompressible state of the unit square held at its boundary: u the curl
/// of sin^2(pi x) sin^2(pi y) / 10 and a pressure cos(pi x) cos(pi y), both times 10^-3, mu = 1 and lambda so
/// large that its finite value does not matter. Root mean squares over those of the solution itself.
struct Errors {
  double displacement, pressure;
};

template <class Element>
Errors manufactured(Index n) {
  const LinearElastic material{3, 0.49999, 1};
  const double mu = shear_modulus(material.young, material.poisson),
               lame = lame_modulus(material.young, material.poisson);
  const Solid<2, Element, LinearElastic> solid(block_mesh<Element>(n, n, bent), material);
  const auto sine = [](double x) { return std::sin(pi * x); };
  const auto cosine = [](double x) { return std::cos(pi * x); };
  // u = (a(x) b(y), -b(x) a(y)) / 10 with a = sin^2, b = a' and so on.
  const auto a = [&](double x) { return sine(x) * sine(x); };
  const auto b = [&](double x) { return 2 * pi * sine(x) * cosine(x); };
  const auto c = [&](double x) { return 2 * pi * pi * std::cos(2 * pi * x); };  // b'
  const auto d = [&](double x) { return -4 * pi * pi * b(x); };                 // c'
  const auto displacement = [&](const Vector<2>& x) {
    return Vector<2>(1e-4 * a(x[0]) * b(x[1]), -1e-4 * b(x[0]) * a(x[1]));
  };
  const auto pressure = [&](const Vector<2>& x) { return 1e-3 * cosine(x[0]) * cosine(x[1]); };
  const auto load_at = [&](const Vector<2>& x) {  // -mu laplace u + grad p
    return Vector<2>(
        -1e-4 * mu * (c(x[0]) * b(x[1]) + a(x[0]) * d(x[1])) - 1e-3 * pi * sine(x[0]) * cosine(x[1]),
        1e-4 * mu * (d(x[0]) * a(x[1]) + b(x[0]) * c(x[1])) - 1e-3 * pi * cosine(x[0]) * sine(x[1]));
  };
  Eigen::VectorXd load = Eigen::VectorXd::Zero(solid.reference.size());
  for (const auto& cell : solid.cells) {
    const auto rest = solid.gather(cell, solid.reference);
    typename Element::VolumeShares shares = Element::VolumeShares::Zero();
    Element::add_volume_shares(cell, shares);
    for (int i = 0; i < Element::n_nodes; ++i)
      load.template segment<2>(2 * cell.node[static_cast<std::size_t>(i)]) +=
          shares[i] * load_at(rest.col(i));
  }
  const Eigen::VectorXd x = solid.equilibrium(solid.reference, load, boundary_dofs(solid.mesh), 1e-5);
  Errors error{0, 0}, scale{0, 0};
  const Eigen::VectorXd volume = solid.lumped_volume();
  for (Index i = 0; i < x.size(); i += 2) {
    const Vector<2> at = solid.reference.template segment<2>(i), exact = displacement(at);
    error.displacement += volume[i] * (x.template segment<2>(i) - at - exact).squaredNorm();
    scale.displacement += volume[i] * exact.squaredNorm();
  }
  // Pressures are known up to a constant: the mean is taken out.
  Array<std::array<double, 3>> pressures;  // volume, found, exact
  for (const auto& cell : solid.cells) {
    const auto now = solid.gather(cell, x), rest = solid.gather(cell, solid.reference);
    double change = 0;
    for (const auto& point : cell.points)
      for (std::size_t i = 0; i < point.support.size(); ++i)
        change +=
            point.volume * (now - rest).col(point.support[i]).dot(point.gradients.col(static_cast<Index>(i)));
    pressures.push_back({cell.volume, -lame * change / cell.volume, pressure(rest.rowwise().mean())});
  }
  double mean = 0;
  for (const auto& [v, found, exact] : pressures) mean += v * (found - exact);
  for (const auto& [v, found, exact] : pressures) {
    error.pressure += v * (found - exact - mean) * (found - exact - mean);
    scale.pressure += v * exact * exact;
  }
  return {std::sqrt(error.displacement / scale.displacement), std::sqrt(error.pressure / scale.pressure)};
}

}  // namespace

TEMPLATE_TEST_CASE("oedometer as nu -> 1/2: uniform pressure, and the force in closed form", "",
                   LinearSimplex<2>, MacroSimplex<2>, CompositeSimplex<2>, QuadraticSimplex<2>,
                   ResistingSimplex<2>, Brick<2>) {
  for (const double poisson : {0.3, 0.495, 0.4999, 0.49995}) {  // the last is kappa / G = 10^4
    const double stretch =
        1 - 0.2 / (1 + lame_modulus(1, poisson));  // the pressure is that of a hard packing
    const auto [lowest, highest, force] = oedometer<TestType>(poisson, stretch);
    const double mu = shear_modulus(1, poisson), lame = lame_modulus(1, poisson);
    const double expected = mu * (stretch - 1 / stretch) + lame * std::log(stretch) / stretch;
    INFO("nu = " << poisson);
    CHECK_THAT(force, WithinRel(expected, 1e-8));
    CHECK(lowest > 0);
    CHECK(highest - lowest < 1e-6 * lowest);
  }
  CHECK_THAT(bulk_modulus(1, 0.49995) / shear_modulus(1, 0.49995), WithinRel(1e4, 1e-3));
}

TEMPLATE_TEST_CASE(
    "convergence without locking: displacement of second order, pressure of first, no checkerboard", "",
    MacroSimplex<2>, CompositeSimplex<2>, QuadraticSimplex<2>, ResistingSimplex<2>, Brick<2>) {
  const auto coarse = manufactured<TestType>(16), fine = manufactured<TestType>(32);
  const double order = std::log2(coarse.displacement / fine.displacement),
               pressure_order = std::log2(coarse.pressure / fine.pressure);
  INFO(TestType::name << ": displacement " << fine.displacement << ", order " << order << "; pressure "
                      << fine.pressure << ", order " << pressure_order);
  CHECK_THAT(order, WithinAbs(2.0, 0.15));
  CHECK(pressure_order > 0.9);
  CHECK(fine.displacement < 0.005);
  CHECK(fine.pressure < (TestType::name == "macro" ? 0.12 : 0.02));
}

TEST_CASE("the linear triangle locks: no motion, and a checkerboard a hundred times the pressure") {
  const auto errors = manufactured<LinearSimplex<2>>(32);
  CHECK(errors.displacement > 0.9);
  CHECK(errors.pressure > 100);
}
