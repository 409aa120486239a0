// SPDX-License-Identifier: MIT
#include <Eigen/Eigenvalues>
#include <cmath>

#include "../catch.hpp"
#include "blocks.hpp"

using namespace jampack;
using namespace jampack_tests;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

/// Cook's membrane: corners (0, 0), (48, 44), (48, 60), (0, 44), n x n quadrilaterals.
Vector<2> cook(double s, double t) {
  return {48 * s, 44 * s + t * (44 - 28 * s)};
}

template <int Dim, class Element>
Mesh<Dim> cook_mesh(Index n) {
  if constexpr (Dim == 2) {
    return block_mesh<Element>(n, n, cook);
  } else {
    Mesh<3> mesh = extruded(triangles(n, n, cook), 48.0 / static_cast<double>(n), 1);
    add_macros(mesh, straight<3>);
    return mesh;
  }
}

/// Vertical displacement of the corner (48, 60) under a shear load of resultant 1 on the side x = 48, the
/// side x = 0 held; small strain, plane strain (in 3D by holding all z), E = 70, nu = 0.4999.
template <int Dim, class Element>
double cook_deflection(Index n) {
  const Solid<Dim, Element, LinearElastic> solid(cook_mesh<Dim, Element>(n), {70, 0.4999, 1});
  const auto& nodes = solid.mesh.nodes;
  std::set<Index> held;
  Index corner = 0;
  for (Index i = 0; i < nodes.size(); ++i) {
    if (nodes[i][0] < 1e-9)
      for (int d = 0; d < Dim; ++d) held.insert(Dim * i + d);
    if (Dim == 3) held.insert(Dim * i + Dim - 1);
    if ((nodes[i].template head<2>() - Vector<2>(48, 60)).norm() < 1e-9) corner = i;
  }
  // Uniform traction on x = 48, shared as linear faces share it: a matter of a few nodes' distance only.
  Eigen::VectorXd load = Eigen::VectorXd::Zero(solid.reference.size());
  double depth = 0;
  for (const auto& node : nodes) depth = std::max(depth, Dim == 3 ? node[Dim - 1] : 1.0);
  for (const auto& face : solid.mesh.faces) {
    bool loaded = true;
    for (Index i = 0; i < face.n_nodes; ++i)
      loaded = loaded && nodes[face.node[static_cast<std::size_t>(i)]][0] > 48 - 1e-9;
    if (!loaded) continue;
    const auto at = [&](std::size_t i) { return nodes[face.node[i]]; };
    if (Dim == 2 && face.n_nodes == 2) {
      for (std::size_t i = 0; i < 2; ++i) load[2 * face.node[i] + 1] += (at(1) - at(0)).norm() / 16 / 2;
    } else if constexpr (Dim == 2) {
      const double share = (at(1) - at(0)).norm() / 16 / 6;  // Simpson's rule
      load[2 * face.node[0] + 1] += share;
      load[2 * face.node[1] + 1] += share;
      load[2 * face.node[2] + 1] += 4 * share;
    } else {  // a quadratic triangle: thirds to its mid nodes
      const double share = (at(1) - at(0)).cross(at(2) - at(0)).norm() / 2 / (16 * depth) / 3;
      for (std::size_t i = 3; i < 6; ++i) load[3 * face.node[i] + 1] += share;
    }
  }
  const Eigen::VectorXd x = solid.equilibrium(solid.reference, load, held, 1e-5);
  return x[Dim * corner + 1] - solid.reference[Dim * corner + 1];
}

/// Volume alone: its force at rest is dv/dx.
struct VolumeOnly {
  double density = 1;
  static constexpr bool finite_strain = true;
  void validate() const {}
  template <int Dim>
  double distortional_energy(const Deformation<Dim>&) const {
    return 0;
  }
  template <int Dim>
  Matrix<Dim> distortional_stress(const Deformation<Dim>&) const {
    return Matrix<Dim>::Zero();
  }
  template <int Dim>
  GradientTangent distortional_tangent(const Deformation<Dim>&) const {
    return {0, 0};
  }
  VolumetricResponse volumetric(double J) const { return {J, 1, 0}; }
};

/// Discrete inf-sup constant of a free grain: the root of the smallest eigenvalue of B A^-1 B^T against the
/// volumes of the pressures, A being the H1 product (2 eps : eps and the mass over diameter squared).
/// Pressure modes that no motion feels (checkerboards) make it zero, locking makes it fall with refinement.
template <int Dim, class Element>
double inf_sup(const Mesh<Dim>& mesh) {
  const Solid<Dim, Element, NeoHookean> solid(mesh, {2, 0, 1});  // mu = 1, lambda = 0
  Eigen::SparseMatrix<double> a = solid.tangent(solid.reference);
  a.diagonal() += solid.lumped_volume();
  const Index n_cells = solid.cells.size();
  Eigen::MatrixXd b = Eigen::MatrixXd::Zero(solid.reference.size(), n_cells);
  Eigen::VectorXd root_volume(n_cells);
  for (Index c = 0; c < n_cells; ++c) {
    const auto& cell = solid.cells[c];
    typename Element::Nodal f;
    Element::force(cell, VolumeOnly{}, solid.gather(cell, solid.reference), f);
    for (int i = 0; i < Element::n_nodes; ++i)
      b.col(c).template segment<Dim>(Dim * cell.node[static_cast<std::size_t>(i)]) += f.col(i);
    root_volume[c] = std::sqrt(cell.volume);
  }
  b = b * root_volume.cwiseInverse().asDiagonal();
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(a);
  const Eigen::MatrixXd schur = b.transpose() * factor.solve(b);
  return std::sqrt(std::max(0.0, Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(schur).eigenvalues()[0]));
}

/// Lowest eigenvalues of the tangent against the lumped mass, rigid motions taken out, at the affine state
/// that is compressed to `stretch` along one axis at constant volume.
template <int Dim, class Element>
Eigen::VectorXd elastic_spectrum(Index wanted, double poisson, double stretch) {
  const Solid<Dim, Element, NeoHookean> solid(mesh_for<Element>(wanted), {1, poisson, 1});
  Vector<Dim> stretches = Vector<Dim>::Constant(Dim == 2 ? 1 / stretch : 1 / std::sqrt(stretch));
  stretches[Dim - 1] = stretch;
  Eigen::VectorXd x = solid.reference;
  for (Index i = 0; i < x.size(); ++i) x[i] *= stretches[i % Dim];
  const Eigen::VectorXd root = solid.lumped_volume().cwiseSqrt();
  Eigen::MatrixXd k =
      root.cwiseInverse().asDiagonal() * Eigen::MatrixXd(solid.tangent(x)) * root.cwiseInverse().asDiagonal();
  // Projected on the complement of the rigid motions: their zeros come first and are left out. Another zero
  // or a negative value would push one of them among what is returned.
  Eigen::MatrixXd rigid = root.asDiagonal() * rigid_motions<Dim>(x);
  rigid = Eigen::HouseholderQR<Eigen::MatrixXd>(rigid).householderQ() *
          Eigen::MatrixXd::Identity(x.size(), rigid.cols());
  const Eigen::MatrixXd out = Eigen::MatrixXd::Identity(x.size(), x.size()) - rigid * rigid.transpose();
  k = (out * k * out).eval();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum(k, Eigen::EigenvaluesOnly);
  REQUIRE(spectrum.info() == Eigen::Success);
  return spectrum.eigenvalues().tail(x.size() - rigid.cols());
}

}  // namespace

TEST_CASE("Cook's membrane at nu = 0.4999: within 2 % where the linear triangle is off by more than 30 %") {
  // The reference is bounded by two meshes of quadratic elements; linear elements approach it from below.
  const double coarse = cook_deflection<2, QuadraticSimplex<2>>(16),
               reference = cook_deflection<2, QuadraticSimplex<2>>(32);
  CHECK_THAT(coarse, WithinRel(reference, 2e-3));
  CHECK_THAT((cook_deflection<2, MacroSimplex<2>>(32)), WithinRel(reference, 0.02));
  CHECK_THAT((cook_deflection<2, CompositeSimplex<2>>(16)), WithinRel(reference, 0.02));
  CHECK_THAT((cook_deflection<2, Brick<2>>(16)), WithinRel(reference, 0.02));
  CHECK_THAT((cook_deflection<2, QuadraticSimplex<2>>(4)), WithinRel(reference, 0.02));
  CHECK_THAT((cook_deflection<2, ResistingSimplex<2>>(8)), WithinRel(reference, 0.02));
  const double locked = cook_deflection<2, LinearSimplex<2>>(32);
  CHECK(locked < 0.7 * reference);
  CHECK(locked > 0);
}

TEST_CASE("Cook's membrane in 3D, plane strain: the 2D deflection on the same grid") {
  const double reference = cook_deflection<2, QuadraticSimplex<2>>(32);
  // The same resultant on a depth of 48 / n.
  const Index n = 8;
  const double depth = 48.0 / static_cast<double>(n);
  CHECK_THAT((depth * cook_deflection<3, QuadraticSimplex<3>>(n)), WithinRel(reference, 0.02));
  const double flat = cook_deflection<2, MacroSimplex<2>>(n);
  CHECK_THAT((depth * cook_deflection<3, MacroSimplex<3>>(n)), WithinRel(flat, 0.02));
  CHECK(depth * cook_deflection<3, LinearSimplex<3>>(n) < 0.7 * reference);
}

namespace {

/// Force, over its closed form, that squeezes a thin strip (plane strain) bonded to rigid plates, nu =
/// 0.4999:
///   F = 2 a kappa (delta / h) (1 - tanh(alpha a) / (alpha a)),  alpha^2 = 12 G / (kappa h^2),  h << a,
/// half its width a, its height h = 1, n_x x n_y quadrilaterals cut in two.
template <class Element>
double squeeze_ratio(double a, Index n_x, Index n_y) {
  const auto mesh =
      block_mesh<Element>(n_x, n_y, [a](double s, double t) { return Vector<2>(a * (2 * s - 1), t); });
  const Solid<2, Element, LinearElastic> solid(mesh, {1, 0.4999, 1});
  const double squeeze = 1e-3;
  Eigen::VectorXd x = solid.reference;
  std::set<Index> held;
  for (Index i = 0; i < x.size(); i += 2) {
    if (x[i + 1] > 1e-9 && x[i + 1] < 1 - 1e-9) continue;
    held.insert({i, i + 1});
    if (x[i + 1] > 0.5) x[i + 1] -= squeeze;
  }
  x = solid.equilibrium(x, Eigen::VectorXd::Zero(x.size()), held, 1e-6);
  const Eigen::VectorXd f = solid.force(x);
  double force = 0;
  for (Index i = 0; i < x.size(); i += 2)
    if (solid.reference[i + 1] > 0.5) force -= f[i + 1];
  const double kappa = bulk_modulus(1, 0.4999), alpha = std::sqrt(12 * shear_modulus(1, 0.4999) / kappa);
  return force / (2 * a * kappa * squeeze * (1 - std::tanh(alpha * a) / (alpha * a)));
}

}  // namespace

TEST_CASE("bonded strip in squeeze: within 2 % where the linear triangle is off by more than 30 %") {
  const double half_width = 10;
  CHECK_THAT(squeeze_ratio<MacroSimplex<2>>(half_width, 80, 4), WithinRel(1.0, 0.01));
  CHECK_THAT(squeeze_ratio<CompositeSimplex<2>>(half_width, 80, 4), WithinRel(1.0, 0.02));
  CHECK_THAT(squeeze_ratio<QuadraticSimplex<2>>(half_width, 80, 4), WithinRel(1.0, 0.02));
  CHECK_THAT(squeeze_ratio<ResistingSimplex<2>>(half_width, 80, 4), WithinRel(1.0, 0.02));
  CHECK_THAT(squeeze_ratio<Brick<2>>(half_width, 80, 4), WithinRel(1.0, 0.02));
  CHECK(squeeze_ratio<LinearSimplex<2>>(half_width, 80, 4) > 1.3);
}

TEST_CASE("no checkerboard: the inf-sup constant of the locking-free elements stays away from zero") {
  for (const Index wanted : {100, 400, 1600}) {
    CHECK(inf_sup<2, MacroSimplex<2>>(disk_mesh(wanted)) > 0.5);
    CHECK(inf_sup<2, CompositeSimplex<2>>(disk_mesh(wanted)) > 0.5);
    CHECK(inf_sup<2, QuadraticSimplex<2>>(disk_mesh(wanted)) > 0.6);
  }
  for (const Index wanted : {100, 400, 816, 3000}) {
    CHECK(inf_sup<3, MacroSimplex<3>>(ball_mesh(wanted)) > 0.2);
    CHECK(inf_sup<3, CompositeSimplex<3>>(ball_mesh(wanted)) > 0.2);
    CHECK(inf_sup<3, QuadraticSimplex<3>>(ball_mesh(wanted)) > 0.3);
  }
  // What locking looks like: falling with refinement in 2D, more pressures than motions in 3D.
  CHECK(inf_sup<2, LinearSimplex<2>>(disk_mesh(400)) < 0.3 * inf_sup<2, LinearSimplex<2>>(disk_mesh(100)));
  CHECK(inf_sup<3, LinearSimplex<3>>(ball_mesh(400)) < 1e-6);
}

TEMPLATE_TEST_CASE_SIG(
    "lowest elastic eigenvalues within 1.5 of the quadratic element's, at rest and at 40 % compression", "",
    ((int Dim), Dim), 2, 3) {
  for (const double stretch : {1.0, 0.6}) {
    const Index wanted = Dim == 2 ? 100 : 400;
    const auto quadratic = elastic_spectrum<Dim, QuadraticSimplex<Dim>>(wanted, 0.495, stretch);
    const auto check = [&](std::string_view name, const Eigen::VectorXd& values) {
      for (int i = 0; i < 4; ++i) {
        INFO("stretch " << stretch << ": " << name << " " << values[i] << ", quadratic " << quadratic[i]);
        CHECK(values[i] > 0);
        CHECK(values[i] > quadratic[i] / 1.5);
        CHECK(values[i] < quadratic[i] * 1.5);
      }
    };
    check("macro", elastic_spectrum<Dim, MacroSimplex<Dim>>(wanted, 0.495, stretch));
    check("resisting", elastic_spectrum<Dim, ResistingSimplex<Dim>>(wanted, 0.495, stretch));
    check("composite", elastic_spectrum<Dim, CompositeSimplex<Dim>>(wanted, 0.495, stretch));
    check("brick", elastic_spectrum<Dim, Brick<Dim>>(wanted, 0.495, stretch));
  }
}
