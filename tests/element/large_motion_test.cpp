// SPDX-License-Identifier: MIT
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "../catch.hpp"
#include "solid.hpp"

using namespace jampack;
using namespace jampack_tests;
using Catch::Matchers::WithinAbs;

namespace {

template <int Dim>
Matrix<Dim> rotation_by(double angle) {
  if constexpr (Dim == 2)
    return Eigen::Rotation2Dd(angle).toRotationMatrix();
  else
    return Eigen::AngleAxisd(angle, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
}

template <class Element, class M>
double total_energy(const Solid<Element::Nodal::RowsAtCompileTime, Element, M>& solid,
                    const Eigen::VectorXd& x) {
  double energy = 0;
  for (const auto& cell : solid.cells) energy += Element::energy(cell, solid.material, solid.gather(cell, x));
  return energy;
}

/// Follows the exact gradient down with the positive semi-definite tangent until the force vanishes; steps
/// that invert a cell have infinite energy and are halved away. Returns the number of steps.
template <class Element>
int relax(const Solid<Element::Nodal::RowsAtCompileTime, Element, NeoHookean>& solid, Eigen::VectorXd& x) {
  constexpr int Dim = Element::Nodal::RowsAtCompileTime;
  const Eigen::VectorXd volume = solid.lumped_volume();
  double energy = total_energy<Element, NeoHookean>(solid, x);
  for (int step = 0; step < 200; ++step) {
    const Eigen::VectorXd force = solid.force(x);
    if (force.norm() < 1e-10) return step;
    Eigen::MatrixXd k = Eigen::MatrixXd::Zero(x.size(), x.size());
    for (const auto& cell : solid.cells) {
      typename Element::Nodal f;
      typename Element::Tangent local;
      Element::force_and_definite_tangent(cell, solid.material, solid.gather(cell, x), f, local);
      for (int i = 0; i < local.rows(); ++i)
        for (int j = 0; j < local.cols(); ++j)
          k(Dim * cell.node[static_cast<std::size_t>(i / Dim)] + i % Dim,
            Dim * cell.node[static_cast<std::size_t>(j / Dim)] + j % Dim) += local(i, j);
    }
    k.diagonal() += 1e-3 * volume;  // rigid motions
    const Eigen::VectorXd direction = k.llt().solve(force);
    for (double share = 1;; share /= 2) {
      const Eigen::VectorXd trial = x - share * direction;
      const double reached = total_energy<Element, NeoHookean>(solid, trial);
      if (reached <= energy - 1e-4 * share * force.dot(direction) || share < 1e-12) {
        x = trial;
        energy = reached;
        break;
      }
    }
  }
  return 1000;
}

}  // namespace

TEMPLATE_TEST_CASE("half a turn of the boundary in steps turns the grain and leaves it without stress", "",
                   MacroSimplex<2>, CompositeSimplex<2>, ResistingSimplex<2>, Brick<2>, MacroSimplex<3>) {
  constexpr int Dim = TestType::Nodal::RowsAtCompileTime;
  const Solid<Dim, TestType, NeoHookean> solid(mesh_for<TestType>(200), {1, 0.495, 1});
  const auto held = boundary_dofs(solid.mesh);
  const int n_steps = 60;
  Eigen::VectorXd x = solid.reference;
  const Matrix<Dim> turn = rotation_by<Dim>(std::numbers::pi / n_steps);
  for (int step = 0; step < n_steps; ++step) {
    for (const Index i : solid.mesh.boundary_nodes)
      x.template segment<Dim>(Dim * i) = turn * x.template segment<Dim>(Dim * i).eval();
    x = solid.equilibrium(x, Eigen::VectorXd::Zero(x.size()), held);
  }
  const Matrix<Dim> half = rotation_by<Dim>(std::numbers::pi);
  double largest = 0;
  for (Index i = 0; i < solid.mesh.nodes.size(); ++i)
    largest = std::max(largest, (x.template segment<Dim>(Dim * i) - half * solid.mesh.nodes[i]).norm());
  CHECK(largest < 1e-9);
  CHECK_THAT((total_energy<TestType, NeoHookean>(solid, x)), WithinAbs(0, 1e-13));
  CHECK(solid.force(x).norm() < 1e-9);
  // Small-strain elasticity does not stand it.
  const Solid<Dim, TestType, LinearElastic> small(mesh_for<TestType>(200), {1, 0.495, 1});
  CHECK((total_energy<TestType, LinearElastic>(small, x)) > 1);
}

TEMPLATE_TEST_CASE("a crushed grain with all but inverted cells recovers its shape", "", LinearSimplex<2>,
                   MacroSimplex<2>, CompositeSimplex<2>, ResistingSimplex<2>, Brick<2>, MacroSimplex<3>) {
  constexpr int Dim = TestType::Nodal::RowsAtCompileTime;
  const Solid<Dim, TestType, NeoHookean> solid(mesh_for<TestType>(100), {1, 0.495, 1});
  Eigen::VectorXd x = solid.reference;
  for (Index i = Dim - 1; i < x.size(); i += Dim) x[i] *= 0.1;
  // Then nodes are moved at random as far as the first cell lets them.
  std::srand(11);
  const Eigen::VectorXd random = Eigen::VectorXd::Random(x.size());
  double size = 0.1;
  while (solid.min_jacobian(x + size * random) <= 1e-4) size *= 0.95;
  x += size * random;
  CHECK(solid.min_jacobian(x) < 0.03);
  const int n_steps = relax<TestType>(solid, x);
  INFO(n_steps << " steps, smallest Jacobian " << solid.min_jacobian(x));
  CHECK(n_steps <= 100);
  // The reference shape, turned and moved.
  double largest = 0;
  for (Index i = 0; i < solid.mesh.nodes.size(); ++i)
    for (Index j = 0; j < i; ++j)
      largest = std::max(
          largest, std::abs((x.template segment<Dim>(Dim * i) - x.template segment<Dim>(Dim * j)).norm() -
                            (solid.mesh.nodes[i] - solid.mesh.nodes[j]).norm()));
  CHECK(largest < 1e-7);
}
