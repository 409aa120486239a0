// SPDX-License-Identifier: MIT
// The patch test of contact: two blocks whose meshes do not match, pressed as a uniform state wants it, are
// in that state to the tolerance of the step.
#include <Eigen/QR>
#include <jampack/detection/weighted_contact.hpp>
#include <jampack/law/signorini_coulomb.hpp>
#include <jampack/stepping/soft_step.hpp>

#include "../catch.hpp"
#include "../element/blocks.hpp"

using namespace jampack;

namespace {

template <int Dim>
Mesh<Dim> block() {
  using namespace jampack_tests;
  const auto bent = [](double x, double y) {
    return Vector<2>(x + 0.3 * x * (1 - x) * (0.2 + y) - 0.5, y + 0.35 * y * (1 - y) * (0.3 + x) - 0.5);
  };
  Mesh<2> base = triangles(2, 2, bent);
  if constexpr (Dim == 2) {
    add_macros(base, straight<2>);
    return base;
  } else {
    Mesh<3> mesh = extruded(base, 1.0, 2);
    for (auto& node : mesh.nodes) node[2] -= 0.5;
    add_macros(mesh, straight<3>);
    return mesh;
  }
}

/// Two blocks, one turned over on top of the other, in a box that they fill and that closes by a factor 0.96:
/// the largest distance of a node from where an affine motion of its block would have it.
template <int Dim, class Element, class Discretisation>
double distance_from_affine(double friction, const SoftStepOptions& options) {
  using Packing = SoftPacking<Dim, Element, NeoHookean>;
  Vector<Dim> corner = Vector<Dim>::Constant(0.5), centre = Vector<Dim>::Zero();
  corner[Dim - 1] = 1;
  centre[Dim - 1] = 0.5;
  Packing packing(block<Dim>(), NeoHookean{.young = 1, .poisson = 0.3}, container(Box<Dim>{-corner, corner}));
  Matrix<Dim> over = Matrix<Dim>::Identity();
  over(Dim - 1, Dim - 1) = over(Dim - 2, Dim - 2) = -1;
  packing.add(1.0, -centre);
  packing.add(1.0, centre, over);
  SoftStep<Packing, SignoriniCoulomb, ProximalNewton, Discretisation> step({friction}, options);
  for (const double scale : {0.99, 0.98, 0.97, 0.96, 0.96, 0.96}) {
    const auto report = step.advance(packing, 100, scale, FirstGuess::rest);
    INFO(report.reason << ", fresh " << report.fresh << " eq " << report.equilibrium_residual);
    REQUIRE(report.converged);
    for (auto& grain : packing.grains) grain.velocity.setZero();  // then inertia fades
  }
  double distance = 0;
  for (const auto& grain : packing.grains) {
    Eigen::MatrixXd reference(packing.n_nodes(), Dim + 1);
    for (Index i = 0; i < packing.n_nodes(); ++i)
      reference.row(i) << packing.model->mesh.nodes[i].transpose(), 1;
    const Eigen::MatrixXd x = grain.position.transpose();
    const Eigen::MatrixXd affine = reference.colPivHouseholderQr().solve(x);
    CHECK(std::abs(affine.topRows(Dim).determinant()) == Approx(std::pow(0.96, Dim)).epsilon(1e-2));
    distance = std::max(distance, (reference * affine - x).cwiseAbs().maxCoeff());
  }
  return distance;
}

constexpr double tight = 1e-8;

SoftStepOptions tightly() {
  SoftStepOptions options;
  options.tolerance = options.scaled_tolerance = tight;
  options.fresh_tolerance = options.fresh_contact_tolerance = 1e3 * tight;
  return options;
}

}  // namespace

TEST_CASE("weighted contact passes the patch test") {
  CHECK(distance_from_affine<2, LinearSimplex<2>, WeightedContact>(0, tightly()) < 10 * tight);
}

TEMPLATE_TEST_CASE("weighted contact passes the patch test in space", "", MacroSimplex<3>,
                   QuadraticSimplex<3>) {
  CHECK(distance_from_affine<3, TestType, WeightedContact>(0, tightly()) < 10 * tight);
  // What slips before frames have settled, friction keeps.
  CHECK(distance_from_affine<3, TestType, WeightedContact>(0.3, tightly()) < 500 * tight);
}

TEST_CASE("contact at samples does not pass it, which is known") {
  CHECK(distance_from_affine<2, MacroSimplex<2>, SampledContact>(0, {}) > 1e-3);
}
