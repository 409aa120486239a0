// SPDX-License-Identifier: MIT
#include <Eigen/Cholesky>
#include <jampack/body/block_cholesky.hpp>
#include <jampack/body/soft_packing.hpp>
#include <jampack/element/macro_simplex.hpp>
#include <jampack/material/neo_hookean.hpp>
#include <jampack/mesh/ball_mesh.hpp>
#include <jampack/mesh/disk_mesh.hpp>
#include <limits>
#include <random>

#include "../catch.hpp"

using namespace jampack;

namespace {

template <int Dim>
struct System {
  BlockPattern pattern;
  BlockMatrix<Dim> matrix;

  Eigen::MatrixXd dense() const {
    const Index n = pattern.n_rows();
    Eigen::MatrixXd full = Eigen::MatrixXd::Zero(Dim * n, Dim * n);
    for (Index i = 0; i < n; ++i)
      for (Index k = pattern.row_start[i]; k < pattern.row_start[i + 1]; ++k)
        full.block<Dim, Dim>(Dim * i, Dim * pattern.column[k]) = matrix.block[k];
    return full;
  }
};

/// Tangent of a stretched neo-Hookean grain, with some of its mass, which holds its rigid motions.
template <int Dim>
System<Dim> stretched_grain(const Mesh<Dim>& mesh) {
  using Model = GrainModel<Dim, MacroSimplex<Dim>, NeoHookean>;
  const Model model(mesh, NeoHookean{});
  const Grain<Model> grain(model, 1.0, Vector<Dim>::Zero(), Matrix<Dim>::Identity());
  auto x = grain.position;
  x.row(0) *= 1.1;
  x.row(1) *= 0.95;
  System<Dim> system{model.pattern, {}};
  typename Grain<Model>::Nodal force;
  REQUIRE(grain.internal_force_and_tangent(model, x, force, system.matrix));
  for (Index i = 0; i < system.pattern.n_rows(); ++i)
    system.matrix.block[system.pattern.position(i, i)] += 10 * grain.mass[i] * Matrix<Dim>::Identity();
  return system;
}

/// Random couplings, about `degree` a node; diagonally dominant.
template <int Dim>
System<Dim> random_system(Index n, double degree, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&] { return double(random()) / double(std::mt19937::max()); };
  Array<Array<Index>> pairs;
  for (Index k = 0; k < Index(degree * double(n) / 2); ++k)
    pairs.push_back({Index(uniform() * double(n - 1)), Index(uniform() * double(n - 1))});
  System<Dim> system{block_pattern(n, pairs), {}};
  auto& block = system.matrix.block;
  system.matrix.set_zero(system.pattern);
  for (Index i = 0; i < n; ++i)
    for (Index k = system.pattern.row_start[i]; k < system.pattern.row_start[i + 1]; ++k) {
      const Index j = system.pattern.column[k];
      if (j > i) continue;
      Matrix<Dim> coupling = Matrix<Dim>::NullaryExpr([&] { return uniform() - 0.5; });
      if (i == j) {
        const Index n_coupled = system.pattern.row_start[i + 1] - system.pattern.row_start[i];
        coupling =
            (coupling + coupling.transpose() + double(Dim * n_coupled) * Matrix<Dim>::Identity()).eval();
      }
      block[k] = coupling;
      block[system.pattern.position(j, i)] = coupling.transpose();
    }
  return system;
}

template <int Dim, class Stored = double>
void check_against_dense(const System<Dim>& system, double tolerance) {
  const Eigen::MatrixXd dense = system.dense();
  const Eigen::LLT<Eigen::MatrixXd> reference(dense);
  REQUIRE(reference.info() == Eigen::Success);
  BlockCholesky<Dim, Stored> cholesky;
  cholesky.analyse(system.pattern);
  REQUIRE(cholesky.factorise(system.matrix));

  const Index n = dense.rows();
  const Eigen::VectorXd b = Eigen::VectorXd::NullaryExpr(n, [](Index i) { return std::sin(double(i * i)); });
  const Eigen::VectorXd expected = reference.solve(b), x = cholesky.solve(b);
  CHECK((x - expected).norm() <= tolerance * expected.norm());

  typename BlockCholesky<Dim, Stored>::RowMajor columns(n, 5);
  for (Index k = 0; k < columns.size(); ++k) columns.data()[k] = std::cos(double(k * k));
  columns.col(4) = b;
  const Eigen::MatrixXd inverse = columns.transpose() * reference.solve(Eigen::MatrixXd(columns));
  cholesky.forward(columns);
  CHECK((columns.transpose() * columns - inverse).norm() <= tolerance * inverse.norm());
  Eigen::VectorXd y = columns.col(4);
  cholesky.backward(y);
  CHECK((y - expected).norm() <= tolerance * expected.norm());
}

}  // namespace

TEST_CASE("Factors of grains agree with the dense factorisation") {
  check_against_dense(stretched_grain<3>(ball_mesh(400)), 1e-10);
  check_against_dense(stretched_grain<3>(ball_mesh(808)), 1e-10);
  check_against_dense(stretched_grain<2>(disk_mesh(100)), 1e-10);
}

TEST_CASE("A factor kept in floats solves to the accuracy of floats, at any scale") {
  auto system = random_system<3>(60, 5, 7);
  check_against_dense<3, float>(system, 1e-5);
  BlockCholesky<3, float> cholesky;
  cholesky.analyse(system.pattern);
  REQUIRE(cholesky.factorise(system.matrix));
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(180, -1, 1);
  CHECK((1e60 * cholesky.solve(1e-60 * b) - cholesky.solve(b)).norm() <= 1e-6 * cholesky.solve(b).norm());
  CHECK(cholesky.solve(0 * b).isZero(0));
}

TEMPLATE_TEST_CASE_SIG("Factors of random patterns agree with the dense factorisation", "", ((int Dim), Dim),
                       2, 3) {
  unsigned seed = 0;
  for (const Index n : {1, 2, 3, 10, 40, 120})
    for (const double degree : {0.0, 0.7, 2.0, 6.0, 30.0}) {  // the first ones are disconnected
      CAPTURE(n, degree);
      check_against_dense(random_system<Dim>(n, degree, ++seed), 1e-12);
    }
}

TEST_CASE("A matrix that is not positive definite or not finite is refused, and the next one is not") {
  auto system = random_system<3>(40, 4, 3);
  BlockCholesky<3> cholesky;
  cholesky.analyse(system.pattern);
  for (Index i = 0; i < system.pattern.n_rows(); ++i)
    for (const double bad :
         {-1.0, 0.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      auto matrix = system.matrix;
      matrix.block[system.pattern.position(i, i)](1, 1) = bad;
      CHECK_FALSE(cholesky.factorise(matrix));
    }
  // Definite block by block, but not as a whole.
  for (const double coupling : {1e3, std::numeric_limits<double>::quiet_NaN()}) {
    auto matrix = system.matrix;
    Index i = 0;
    while (system.pattern.row_start[i + 1] - system.pattern.row_start[i] < 2) ++i;
    const Index first = system.pattern.column[system.pattern.row_start[i]];
    const Index j = first == i ? system.pattern.column[system.pattern.row_start[i] + 1] : first;
    matrix.block[system.pattern.position(i, j)](0, 1) = coupling;
    matrix.block[system.pattern.position(j, i)](1, 0) = coupling;
    CHECK_FALSE(cholesky.factorise(matrix));
  }
  REQUIRE(cholesky.factorise(system.matrix));
  const Eigen::VectorXd b = Eigen::VectorXd::Ones(120);
  CHECK((system.dense() * cholesky.solve(b) - b).norm() < 1e-13);
}

TEST_CASE("Factors that share a structure, or are made again, give the same bits") {
  const auto system = stretched_grain<3>(ball_mesh(400)), other = random_system<3>(200, 10, 5);
  const auto structure = std::make_shared<const CholeskyStructure>(system.pattern);
  BlockCholesky<3> own, first, second, between;
  own.analyse(system.pattern);
  first.analyse(structure);
  second.analyse(structure);
  between.analyse(other.pattern);
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(3 * system.pattern.n_rows(), -1, 2);
  REQUIRE(own.factorise(system.matrix));
  REQUIRE(first.factorise(system.matrix));
  const Eigen::VectorXd x = own.solve(b);
  CHECK(first.solve(b) == x);
  // What others leave in the workspace does not matter.
  REQUIRE(between.factorise(other.matrix));
  between.solve(Eigen::VectorXd::Constant(600, std::numeric_limits<double>::quiet_NaN()));
  REQUIRE(second.factorise(system.matrix));
  between.solve(Eigen::VectorXd::Constant(600, std::numeric_limits<double>::quiet_NaN()));
  CHECK(second.solve(b) == x);
  CHECK(first.solve(b) == x);
  BlockCholesky<3>::RowMajor columns = b, again = b;
  first.forward(columns);
  second.forward(again);
  CHECK(columns == again);
}
