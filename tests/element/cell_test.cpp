// SPDX-License-Identifier: MIT
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <functional>
#include <jampack/element/element.hpp>
#include <jampack/material/hencky.hpp>
#include <limits>
#include <type_traits>

#include "../catch.hpp"
#include "solid.hpp"

using namespace jampack;
using namespace jampack_tests;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

/// A foreign material with a tangent given as a matrix: psi = (a / 4)(|F|^2)^2 - a Dim ln J + (b / 2)(J -
/// 1)^2, a Dim being what makes F = I free of stress.
struct Quartic {
  double a = 0.7, b = 5, density = 1;
  static constexpr bool finite_strain = true;
  void validate() const {}
  double shear() const { return 3 * a; }
  template <int Dim>
  double distortional_energy(const Deformation<Dim>& at) const {
    const double square = at.gradient.squaredNorm();
    return 0.25 * a * square * square - a * Dim * std::log(at.dilatation);
  }
  template <int Dim>
  Matrix<Dim> distortional_stress(const Deformation<Dim>& at) const {
    return a * at.gradient.squaredNorm() * at.gradient - a * Dim * at.inverse_transpose;
  }
  template <int Dim>
  MatrixTangent<Dim> distortional_tangent(const Deformation<Dim>& at) const {
    const Eigen::Matrix<double, Dim * Dim, 1> gradient = at.gradient.reshaped();
    MatrixTangent<Dim> tangent = 2 * a * gradient * gradient.transpose();
    tangent.diagonal().array() += a * at.gradient.squaredNorm();
    for (int i = 0; i < Dim; ++i)
      for (int j = 0; j < Dim; ++j)
        for (int k = 0; k < Dim; ++k)
          for (int l = 0; l < Dim; ++l)
            tangent(Dim * j + i, Dim * l + k) +=
                a * Dim * at.inverse_transpose(i, l) * at.inverse_transpose(k, j);
    return tangent;
  }
  VolumetricResponse volumetric(double J) const { return {0.5 * b * (J - 1) * (J - 1), b * (J - 1), b}; }
};

template <int Dim>
Matrix<Dim> half_turn_and_more() {
  if constexpr (Dim == 2)
    return Eigen::Rotation2Dd(2.5).toRotationMatrix();
  else
    return Eigen::AngleAxisd(2.5, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
}

/// One cell of an element and a material behind functions of plain vectors, so that what is checked below is
/// compiled once and not for every element and material.
struct AnyCell {
  Eigen::VectorXd rest;
  double size;
  std::function<double(const Eigen::VectorXd&)> energy;
  std::function<bool(const Eigen::VectorXd&, Eigen::VectorXd&)> force;
  std::function<bool(const Eigen::VectorXd&, Eigen::VectorXd&, Eigen::MatrixXd&)> tangent, definite_tangent;
};

template <class Element, class M>
AnyCell any_cell(const typename Element::Cell& cell, const M& material, const typename Element::Nodal& rest) {
  using Nodal = typename Element::Nodal;
  using Map = Eigen::Map<const Nodal>;
  const auto derivatives = [=](auto&& evaluate) {
    return [=](const Eigen::VectorXd& x, Eigen::VectorXd& f, Eigen::MatrixXd& k) {
      Nodal force;
      typename Element::Tangent tangent;
      if (!evaluate(Nodal(Map(x.data())), force, tangent)) return false;
      f = Eigen::Map<const Eigen::VectorXd>(force.data(), force.size());
      k = tangent;
      return true;
    };
  };
  return {Eigen::Map<const Eigen::VectorXd>(rest.data(), rest.size()),
          std::pow(cell.volume, 1 / static_cast<double>(rest.rows())),
          [=](const Eigen::VectorXd& x) { return Element::energy(cell, material, Map(x.data())); },
          [=](const Eigen::VectorXd& x, Eigen::VectorXd& f) {
            Nodal force;
            const bool good = Element::force(cell, material, Map(x.data()), force);
            f = Eigen::Map<const Eigen::VectorXd>(force.data(), force.size());
            return good;
          },
          derivatives([=](const Nodal& x, Nodal& f, typename Element::Tangent& k) {
            return Element::force_and_tangent(cell, material, x, f, k);
          }),
          derivatives([=](const Nodal& x, Nodal& f, typename Element::Tangent& k) {
            return Element::force_and_definite_tangent(cell, material, x, f, k);
          })};
}

void check_derivatives(const AnyCell& cell) {
  const double h = 1e-6 * cell.size;
  const Eigen::VectorXd x = cell.rest + 0.08 * cell.size * Eigen::VectorXd::Random(cell.rest.size());
  Eigen::VectorXd f, up, down;
  Eigen::MatrixXd k, definite;
  REQUIRE(cell.tangent(x, f, k));
  REQUIRE(cell.force(x, up));
  CHECK_THAT((f - up).norm(), WithinAbs(0, 1e-14 * f.norm()));
  REQUIRE(cell.definite_tangent(x, up, definite));
  CHECK_THAT((f - up).norm(), WithinAbs(0, 1e-14 * f.norm()));
  CHECK((k - k.transpose()).norm() == 0);
  CHECK((definite - definite.transpose()).norm() == 0);
  CHECK(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(definite).eigenvalues()[0] > -1e-12 * definite.norm());
  for (Index d = 0; d < x.size(); ++d) {
    Eigen::VectorXd forward = x, backward = x;
    forward[d] += h;
    backward[d] -= h;
    REQUIRE(cell.force(forward, up));
    REQUIRE(cell.force(backward, down));
    CHECK_THAT((cell.energy(forward) - cell.energy(backward)) / (2 * h), WithinAbs(f[d], 1e-7 * f.norm()));
    CHECK_THAT(((up - down) / (2 * h) - k.col(d)).norm(), WithinAbs(0, 1e-7 * k.norm()));
  }
}

template <class Element, int Dim, class M>
void check_derivatives(const M& material) {
  const auto mesh = mesh_for<Element>(100);
  const auto cells = Element::cells(mesh, 1.0, Matrix<Dim>::Identity());
  std::srand(3);
  for (Index c = 0; c < cells.size(); c += cells.size() / 5) {
    typename Element::Nodal rest;
    for (int a = 0; a < Element::n_nodes; ++a)
      rest.col(a) = mesh.nodes[cells[c].node[static_cast<std::size_t>(a)]];
    check_derivatives(any_cell<Element>(cells[c], material, rest));
  }
}

}  // namespace

// The quadratic element is the resisting one without a resistance.
#define ALL_ELEMENTS                                                                               \
  (LinearSimplex<2>), (MacroSimplex<2>), (CompositeSimplex<2>), (ResistingSimplex<2>), (Brick<2>), \
      (LinearSimplex<3>), (MacroSimplex<3>), (CompositeSimplex<3>), (ResistingSimplex<3>), (Brick<3>)

template <class Element>
inline constexpr int dim_of = Element::Nodal::RowsAtCompileTime;

TEMPLATE_TEST_CASE("force and tangent are exact derivatives, for every element and material", "",
                   ALL_ELEMENTS) {
  constexpr int Dim = dim_of<TestType>;
  check_derivatives<TestType, Dim>(NeoHookean{1, 0.495, 1});
  check_derivatives<TestType, Dim>(Quartic{});
  if constexpr (std::is_same_v<TestType, MacroSimplex<Dim>>) {
    check_derivatives<TestType, Dim>(NeoHookeanQuadratic{1, 0.3, 1});
    check_derivatives<TestType, Dim>(LinearElastic{1, 0.495, 1});
    check_derivatives<TestType, Dim>(Hencky{1, 0.495, 1});
  }
}

TEMPLATE_TEST_CASE("an element and an assembled grain have the rigid motions as their only zero modes", "",
                   ALL_ELEMENTS) {
  constexpr int Dim = dim_of<TestType>;
  constexpr int n_rigid = Dim == 2 ? 3 : 6;
  const Solid<Dim, TestType, NeoHookean> solid(mesh_for<TestType>(100), {1, 0.495, 1});
  const auto count = [](const Eigen::MatrixXd& k) {
    const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k).eigenvalues();
    CHECK(values[0] > -1e-11 * values[values.size() - 1]);
    return (values.array() < 1e-6 * values[values.size() - 1]).count();
  };
  for (const auto& cell : solid.cells) {
    typename TestType::Nodal f;
    typename TestType::Tangent k;
    TestType::force_and_tangent(cell, solid.material, solid.gather(cell, solid.reference), f, k);
    CHECK_THAT(f.norm(), WithinAbs(0, 1e-13));
    CHECK(count(k) == n_rigid);
  }
  CHECK(count(Eigen::MatrixXd(solid.tangent(solid.reference))) == n_rigid);
}

TEMPLATE_TEST_CASE("energy and force follow a finite rotation", "", ALL_ELEMENTS) {
  constexpr int Dim = dim_of<TestType>;
  const NeoHookean material{1, 0.495, 1};
  const Solid<Dim, TestType, NeoHookean> solid(mesh_for<TestType>(100), material);
  const Matrix<Dim> rotation = half_turn_and_more<Dim>();
  std::srand(4);
  for (const auto& cell : solid.cells) {
    typename TestType::Nodal x = solid.gather(cell, solid.reference), f, turned_force;
    x += 0.05 * std::pow(cell.volume, 1.0 / Dim) * TestType::Nodal::Random();
    typename TestType::Nodal turned = rotation * x;
    turned.colwise() += Vector<Dim>::Constant(3.0);
    REQUIRE(TestType::force(cell, material, x, f));
    REQUIRE(TestType::force(cell, material, turned, turned_force));
    CHECK_THAT((turned_force - rotation * f).norm(), WithinAbs(0, 1e-11 * f.norm()));
    CHECK_THAT(TestType::energy(cell, material, turned),
               WithinRel(TestType::energy(cell, material, x), 1e-9));
    // No resultant and no moment.
    CHECK_THAT(f.rowwise().sum().norm(), WithinAbs(0, 1e-13 * f.norm()));
    const Matrix<Dim> moment = f * x.transpose();
    CHECK_THAT((moment - moment.transpose()).norm(), WithinAbs(0, 1e-13 * f.norm()));
  }
}

TEMPLATE_TEST_CASE("patch test: an affine motion of the boundary is an affine motion of the whole grain", "",
                   ALL_ELEMENTS) {
  constexpr int Dim = dim_of<TestType>;
  const Solid<Dim, TestType, NeoHookean> solid(mesh_for<TestType>(200), {1, 0.495, 1});
  Eigen::Matrix3d affine;
  affine << 1.05, 0.2, 0.0, -0.1, 0.93, 0.1, 0.05, 0.1, 1.02;
  const Matrix<Dim> gradient = affine.topLeftCorner<Dim, Dim>();
  Eigen::VectorXd expected = solid.reference, start;
  for (Index i = 0; i < solid.mesh.nodes.size(); ++i)
    expected.template segment<Dim>(Dim * i) = gradient * solid.mesh.nodes[i];
  std::srand(5);
  const auto held = boundary_dofs(solid.mesh);
  start = expected;
  for (Index i = 0; i < start.size(); ++i)
    if (!held.count(i)) start[i] += 5e-4 * std::sin(static_cast<double>(i * i));
  const Eigen::VectorXd found = solid.equilibrium(start, Eigen::VectorXd::Zero(start.size()), held);
  CHECK((start - expected).norm() > 0.001);
  CHECK_THAT((found - expected).norm(), WithinAbs(0, 1e-10));
  // The stress is the same everywhere: that of the material at F.
  Deformation<Dim> at{gradient, gradient.inverse().transpose(), gradient.determinant()};
  Matrix<Dim> stress = solid.material.distortional_stress(at) * gradient.transpose() / at.dilatation;
  stress.diagonal().array() += solid.material.volumetric(at.dilatation).slope;
  double volume = 0;
  for (const auto& cell : solid.cells)
    TestType::for_each_point(cell, solid.material, solid.gather(cell, found),
                             [&](double reference_volume, const Matrix<Dim>& cauchy, double dilatation) {
                               volume += reference_volume;
                               CHECK_THAT(dilatation, WithinRel(at.dilatation, 1e-9));
                               CHECK_THAT((cauchy - stress).norm(), WithinAbs(0, 1e-6 * stress.norm()));
                             });
  CHECK_THAT(volume, WithinRel(solid.lumped_volume().sum() / Dim, 1e-13));
}

TEMPLATE_TEST_CASE("inversion is reported, and never by a NaN that passes", "", ALL_ELEMENTS) {
  constexpr int Dim = dim_of<TestType>;
  const NeoHookean material{1, 0.3, 1};
  const Solid<Dim, TestType, NeoHookean> solid(mesh_for<TestType>(100), material);
  const auto& cell = solid.cells[7];
  typename TestType::Nodal x = solid.gather(cell, solid.reference), f;
  typename TestType::Tangent k;
  CHECK_THAT(TestType::min_jacobian(cell, x), WithinRel(1.0, 1e-12));
  CHECK(TestType::force(cell, material, x, f));
  typename TestType::Nodal mirrored = x, flat = x, poisoned = x;
  mirrored.row(0) *= -1;
  flat.row(0).setZero();
  poisoned(0, 0) = std::numeric_limits<double>::quiet_NaN();
  CHECK_THAT(TestType::min_jacobian(cell, mirrored), WithinRel(-1.0, 1e-12));
  for (const auto& bad : {mirrored, flat, poisoned}) {
    CHECK(TestType::energy(cell, material, bad) == std::numeric_limits<double>::infinity());
    CHECK_FALSE(TestType::force(cell, material, bad, f));
    CHECK_FALSE(TestType::force_and_tangent(cell, material, bad, f, k));
    CHECK_FALSE(TestType::force_and_definite_tangent(cell, material, bad, f, k));
  }
}

TEMPLATE_TEST_CASE("cells scale with the diameter, turn with the rotation, and share volume positively", "",
                   ALL_ELEMENTS) {
  constexpr int Dim = dim_of<TestType>;
  const auto mesh = mesh_for<TestType>(400);
  const Matrix<Dim> rotation = half_turn_and_more<Dim>();
  const auto plain = TestType::cells(mesh, 1.0, Matrix<Dim>::Identity());
  const auto scaled = TestType::cells(mesh, 3.0, rotation);
  double volume = 0;
  for (Index c = 0; c < plain.size(); ++c) {
    volume += scaled[c].volume;
    CHECK_THAT(scaled[c].volume, WithinRel(plain[c].volume * std::pow(3.0, Dim), 1e-12));
    const auto& gradients = scaled[c].points[0].gradients;
    CHECK_THAT((3 * rotation.transpose() * gradients - plain[c].points[0].gradients).norm(),
               WithinAbs(0, 1e-11 * gradients.norm()));
    typename TestType::VolumeShares shares = TestType::VolumeShares::Zero();
    TestType::add_volume_shares(scaled[c], shares);
    CHECK(shares.minCoeff() > 0);
    CHECK_THAT(shares.sum(), WithinRel(scaled[c].volume, 1e-13));
  }
  // Straight cells have the volume of the inscribed polyhedron, curved ones nearly that of the ball.
  if (TestType::name == "resisting" || TestType::name == "brick")
    CHECK_THAT(volume, WithinRel(TestType::name == "brick" ? mesh_volume(mesh) * std::pow(3.0, Dim)
                                                           : ball_volume<Dim>(3),
                                 Dim == 2 ? 1e-3 : 1e-2));
  else
    CHECK_THAT(volume, WithinRel(mesh_volume(mesh) * std::pow(3.0, Dim), 1e-12));
}

TEST_CASE("the Element concept: accepted and rejected") {
  STATIC_REQUIRE(Element<LinearSimplex<3>, 3, NeoHookean>);
  STATIC_REQUIRE(Element<MacroSimplex<2>, 2, LinearElastic>);
  STATIC_REQUIRE(Element<QuadraticSimplex<3>, 3, Quartic>);
  STATIC_REQUIRE(Element<ResistingSimplex<3>, 3, NeoHookean>);
  STATIC_REQUIRE(Element<CompositeSimplex<3>, 3, Quartic>);
  STATIC_REQUIRE(Element<Brick<2>, 2, NeoHookean>);
  STATIC_REQUIRE_FALSE(Element<LinearSimplex<3>, 2, NeoHookean>);
  STATIC_REQUIRE_FALSE(Element<LinearSimplex<3>, 3, LogarithmicVolume>);
  STATIC_REQUIRE_FALSE(Element<NeoHookean, 3, NeoHookean>);
}

TEST_CASE("a mesh without macros serves the linear element alone") {
  auto mesh = ball_mesh(100);
  mesh.macros.clear();
  const Matrix<3> identity = Matrix<3>::Identity();
  CHECK(LinearSimplex<3>::cells(mesh, 1.0, identity).size() == mesh.cells.size());
  CHECK_THROWS_AS(MacroSimplex<3>::cells(mesh, 1.0, identity), InvalidInput);
  CHECK_THROWS_AS(CompositeSimplex<3>::cells(mesh, 1.0, identity), InvalidInput);
  CHECK_THROWS_AS(QuadraticSimplex<3>::cells(mesh, 1.0, identity), InvalidInput);
  CHECK_THROWS_AS(Brick<3>::cells(mesh, 1.0, identity), InvalidInput);
  std::swap(mesh.cells[4][0], mesh.cells[4][1]);
  CHECK_THROWS_AS(LinearSimplex<3>::cells(mesh, 1.0, identity), InvalidInput);
}
