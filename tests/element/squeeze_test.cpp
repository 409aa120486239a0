// SPDX-License-Identifier: MIT
#include <numbers>

#include "../catch.hpp"
#include "blocks.hpp"

using namespace jampack;
using namespace jampack_tests;
using Catch::Matchers::WithinRel;

namespace {

/// Modified Bessel function of the first kind by its series.
double bessel_i(int order, double x) {
  double term = std::pow(x / 2, order) / std::tgamma(order + 1), sum = term;
  for (int k = 1; k < 40; ++k) sum += term *= x * x / 4 / (k * (k + order));
  return sum;
}

/// Force, over its closed form, that squeezes a thin disc of height 1 and the given radius bonded to rigid
/// plates, nu = 0.4999:
///   F = pi R^2 kappa (delta / h) I_2(alpha R) / I_0(alpha R),  alpha^2 = 12 G / (kappa h^2),  h << R.
/// A quarter of the disc between planes of symmetry: n_r rings of n_turn pieces, n_z layers.
template <class Element>
double disc_squeeze_ratio(double radius, Index n_r, Index n_turn, Index n_z) {
  Mesh<2> base;
  base.nodes.push_back(Vector<2>::Zero());
  for (Index i = 1; i <= n_r; ++i)
    for (Index j = 0; j <= n_turn; ++j) {
      const double angle = std::numbers::pi / 2 * static_cast<double>(j) / static_cast<double>(n_turn);
      base.nodes.push_back(radius * static_cast<double>(i) / static_cast<double>(n_r) *
                           Vector<2>(std::cos(angle), std::sin(angle)));
    }
  for (Index j = 0; j < n_turn; ++j) base.cells.push_back({0, 1 + j, 2 + j});
  for (Index i = 1; i < n_r; ++i)
    for (Index j = 0; j < n_turn; ++j) {
      const Index inner = 1 + (i - 1) * (n_turn + 1) + j, outer = inner + n_turn + 1;
      base.cells.push_back({inner, outer, outer + 1});
      base.cells.push_back({inner, outer + 1, inner + 1});
    }
  Mesh<3> mesh = extruded(base, 1, n_z);
  add_macros(mesh, [](const Vector<3>& a, const Vector<3>& b) {  // on circles, except on the planes' edges
    Vector<3> middle = (a + b) / 2;
    const double size = middle.head<2>().norm(), wanted = (a.head<2>().norm() + b.head<2>().norm()) / 2;
    if (size > 0) middle.head<2>() *= wanted / size;
    return middle;
  });
  const Solid<3, Element, LinearElastic> solid(mesh, {1, 0.4999, 1});
  const double squeeze = 1e-3;
  Eigen::VectorXd x = solid.reference;
  std::set<Index> held;
  for (Index i = 0; i < x.size(); i += 3) {
    if (x[i] < 1e-9) held.insert(i);
    if (x[i + 1] < 1e-9) held.insert(i + 1);
    if (x[i + 2] > 1e-9 && x[i + 2] < 1 - 1e-9) continue;
    held.insert({i, i + 1, i + 2});
    if (x[i + 2] > 0.5) x[i + 2] -= squeeze;
  }
  x = solid.equilibrium(x, Eigen::VectorXd::Zero(x.size()), held, 1e-6);
  const Eigen::VectorXd f = solid.force(x);
  double force = 0;
  for (Index i = 0; i < x.size(); i += 3)
    if (solid.reference[i + 2] > 0.5) force -= 4 * f[i + 2];
  const double kappa = bulk_modulus(1, 0.4999),
               alpha = std::sqrt(12 * shear_modulus(1, 0.4999) / kappa) * radius;
  return force /
         (std::numbers::pi * radius * radius * kappa * squeeze * bessel_i(2, alpha) / bessel_i(0, alpha));
}

}  // namespace

TEST_CASE("bonded disc in squeeze: within 2 % where the linear tetrahedron is off by more than 30 %") {
  CHECK_THAT(disc_squeeze_ratio<MacroSimplex<3>>(10, 20, 4, 3), WithinRel(1.0, 0.02));
  CHECK_THAT(disc_squeeze_ratio<QuadraticSimplex<3>>(10, 30, 4, 3), WithinRel(1.0, 0.02));
  CHECK(disc_squeeze_ratio<LinearSimplex<3>>(10, 20, 4, 3) > 1.3);
}
