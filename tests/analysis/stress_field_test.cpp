// SPDX-License-Identifier: MIT
#include <jampack/analysis/stress_field.hpp>
#include <jampack/element/linear_simplex.hpp>
#include <jampack/element/macro_simplex.hpp>
#include <jampack/material/linear_elastic.hpp>
#include <jampack/material/neo_hookean.hpp>
#include <jampack/mesh/disk_mesh.hpp>

#include "../catch.hpp"

using namespace jampack;
using Catch::Matchers::WithinRel;

namespace {

/// The Cauchy stress of the three-dimensional neo-Hookean solid at F, written out: mu / J (F F^T - 1) +
/// lambda ln J / J.
Matrix<3> neo_hookean_stress(const NeoHookean& m, const Matrix<3>& f) {
  const double mu = m.young / (2 * (1 + m.poisson));
  const double lambda = m.young * m.poisson / ((1 + m.poisson) * (1 - 2 * m.poisson));
  const double j = f.determinant();
  const Matrix<3> excess = f * f.transpose() - Matrix<3>::Identity();
  return mu / j * excess + lambda * std::log(j) / j * Matrix<3>::Identity();
}

}  // namespace

TEST_CASE("Von Mises stress in plane strain is that of the solid the plane is cut from", "[stress_field]") {
  const NeoHookean material{.young = 2, .poisson = 0.45};
  for (const auto& [a, b, c, d] : {std::array{1.1, 0.3, -0.1, 0.8}, std::array{0.7, 0.0, 0.0, 1.0},
                                   std::array{0.9, 0.0, 0.0, 0.9}, std::array{0.8, -0.6, 0.6, 0.8}}) {
    Matrix<3> f = Matrix<3>::Identity();
    f.topLeftCorner<2, 2>() << a, b, c, d;
    const Matrix<3> stress = neo_hookean_stress(material, f);
    const double expected = von_mises(stress);
    const double found =
        von_mises_at_point<2>(material, Matrix<2>(stress.topLeftCorner<2, 2>()), f.determinant());
    CHECK(std::abs(found - expected) < 1e-13);
  }
}

TEMPLATE_TEST_CASE("The von Mises field of homogeneous strain is one number, over the whole volume",
                   "[stress_field]", LinearSimplex<2>, MacroSimplex<2>) {
  const NeoHookean material{.young = 1, .poisson = 0.4};
  SoftPacking<2, TestType, NeoHookean> packing(disk_mesh(100), material, container(centred_cube<2>(2.0)));
  packing.add(1.0, Vector<2>::Zero());
  Matrix<3> f = Matrix<3>::Identity();
  f.topLeftCorner<2, 2>() << 1.05, 0.2, -0.1, 0.9;
  auto& x = packing.grains[0].position;
  x = (f.topLeftCorner<2, 2>() * x).eval();
  const double expected = von_mises(neo_hookean_stress(material, f));
  const auto field = von_mises_field(packing);
  double volume = 0;
  for (const double weight : field.weights) volume += weight;
  CHECK_THAT(volume, WithinRel(mesh_volume(packing.model->mesh), 1e-12));
  CHECK_THAT(field_moments(field).mean, WithinRel(expected, 1e-12));
  CHECK(normalised_standard_deviation(field) < 1e-7);
  for (const double value : nodal_von_mises(packing, 0)) CHECK_THAT(value, WithinRel(expected, 1e-12));
}
