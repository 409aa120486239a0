// SPDX-License-Identifier: MIT
#include <Eigen/LU>
#include <jampack/solver/ball_newton_matrix.hpp>
#include <jampack/solver/grain_newton_matrix.hpp>
#include <random>

#include "../catch.hpp"
#include "ball_packing.hpp"

using namespace jampack;

namespace {

// Grains in a row, each in contact with the next two and some with a wall; several contacts a pair.
template <int N>
GrainComplianceDelassus<N> random_grains(Index n_grains, std::mt19937& random) {
  std::normal_distribution<double> normal;
  Array<GrainCompliance<N>> grains(n_grains);
  Index n_contacts = 0;
  const auto touch = [&](Index a, Index b) {
    for (Index k = 0; k < 1 + (a + b) % 3; ++k, ++n_contacts) {
      grains[a].contact.push_back(n_contacts);
      grains[a].sign.push_back(1);
      if (b < 0) continue;
      grains[b].contact.push_back(n_contacts);
      grains[b].sign.push_back(-1);
    }
  };
  for (Index g = 0; g < n_grains; ++g) {
    if (g % 3 == 0) touch(g, -1);
    if (g + 1 < n_grains) touch(g + 1, g);  // candidate after and before the antagonist
    if (g + 2 < n_grains) touch(g, g + 2);
  }
  for (auto& grain : grains) {
    const Index n = N * grain.contact.size();
    const Eigen::MatrixXd a = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return normal(random); });
    grain.compliance = a * a.transpose() / double(n);
  }
  return {n_contacts, std::move(grains)};
}

// A W + C with random A, some contacts open and some without friction, a right-hand side and the solution.
template <class Delassus>
struct NewtonSystem {
  static constexpr int N = Delassus::n_unknowns;
  using Block = Eigen::Matrix<double, N, N>;
  Array<Block> a, constant;
  Array<int> n_rows;
  Eigen::VectorXd b, x;

  NewtonSystem(const Delassus& w, double a_constant, std::mt19937& random) {
    std::normal_distribution<double> normal;
    const Index n = w.n_contacts();
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(N * n, N * n);
    for (Index c = 0; c < n; ++c) {
      a.push_back(Block::NullaryExpr([&] { return normal(random); }));
      constant.push_back(a_constant * Block::Identity());
      n_rows.push_back(c % 5 == 0 ? 0 : c % 4 == 0 ? 1 : N);
    }
    Eigen::VectorXd column;
    for (Index j = 0; j < N * n; ++j) {
      w.apply(Eigen::VectorXd::Unit(N * n, j), column);
      dense.col(j) = column;
    }
    for (Index c = 0; c < n; ++c) dense.middleRows<N>(N * c) = a[c] * dense.middleRows<N>(N * c).eval();
    for (Index c = 0; c < n; ++c) {
      dense.block<N, N>(N * c, N * c) += constant[c];
      for (int i = n_rows[c]; i < N; ++i) {
        dense.row(N * c + i).setZero();
        dense.col(N * c + i).setZero();
        dense(N * c + i, N * c + i) = 1;
      }
    }
    b = Eigen::VectorXd::NullaryExpr(N * n, [&] { return normal(random); });
    x = dense.partialPivLu().solve(b);
  }

  template <class Solve>
  double error(const Solve& solve) const {
    Eigen::VectorXd y = b;
    REQUIRE(solve(y));
    return (y - x).norm() / x.norm();
  }
};

template <int N>
void check(Threads threads) {
  std::mt19937 random(5);
  const auto w = random_grains<N>(9, random);
  const NewtonSystem system(w, 3, random);
  const auto& n_rows = system.n_rows;
  const auto &a = system.a, &constant = system.constant;

  NewtonMatrix<GrainComplianceDelassus<N>> of_grains(w, threads);
  const auto groups = group_contacts(w);
  MultifrontalLU<N> factors(w, groups, threads);
  GrainNewtonGmres<N> gmres(w, groups, threads);
  const auto stored = as_block_sparse(w);
  NewtonMatrix<BlockSparseDelassus<N>> of_blocks(stored);
  for (int again = 0; again < 2; ++again) {  // what was set up is used again
    CHECK(system.error([&](auto& y) { return factors.solve(n_rows, a, constant, y); }) <= 1e-10);
    CHECK(system.error([&](auto& y) { return gmres.solve(n_rows, a, constant, 1e-11, y); }) <= 1e-9);
    CHECK(system.error([&](auto& y) { return of_grains.solve(n_rows, a, constant, y); }) <= 1e-2);
    CHECK(system.error([&](auto& y) {
      if (!of_grains.prepare(n_rows, a, constant)) return false;
      of_grains.precondition(y);
      return true;
    }) <= 1e-10);  // so few contacts are left to factors
    // Grains of at most sixteen unknowns are all modes: the two levels together are exact.
    if (N == 1)
      CHECK(system.error([&](auto& y) {
        if (!gmres.prepare(n_rows, a, constant)) return false;
        gmres.precondition(y);
        return true;
      }) <= 1e-6);
    CHECK(system.error([&](auto& y) { return of_blocks.solve(n_rows, a, constant, y); }) <= 1e-8);
  }
}

}  // namespace

TEST_CASE("the factors of the Newton matrix solve as a dense matrix does") {
  check<1>({});
  check<2>({});
  check<3>({});
  check<3>({.count = 2});
}

TEMPLATE_TEST_CASE_SIG("the Newton matrix of balls solves as a dense matrix does", "",
                       ((int Dim, int N), Dim, N), (2, 1), (2, 2), (3, 1), (3, 3)) {
  // Balls that touch each other and walls that move together; one does not turn, one does not move at all.
  const double constant = GENERATE(3.0, 1e-4);
  auto packing = jampack_tests::pressed_packing<Dim, N>(30, Dim == 2 ? 0.86 : 0.66, 0.3);
  const auto& w = packing.delassus;
  auto bodies = w.bodies();
  bodies[3].spin = 0;
  bodies[7] = {0, 0};
  const RigidBallsDelassus<Dim, N> balls(bodies, w.contacts(), w.mode_inverse_mass());
  std::mt19937 random(6);
  const NewtonSystem<RigidBallsDelassus<Dim, N>> system(balls, constant, random);
  NewtonMatrix<RigidBallsDelassus<Dim, N>> matrix(balls);
  for (int again = 0; again < 2; ++again)
    CHECK(system.error([&](auto& y) { return matrix.solve(system.n_rows, system.a, system.constant, y); }) <=
          1e-7);
}

TEST_CASE("blocks of grain compliances are those of the operator") {
  std::mt19937 random(2);
  const auto w = random_grains<3>(6, random);
  Eigen::VectorXd u;
  for (Index d = 0; d < w.n_contacts(); ++d)
    for (int j = 0; j < 3; ++j) {
      w.apply(Eigen::VectorXd::Unit(3 * w.n_contacts(), 3 * d + j), u);
      for (Index c = 0; c < w.n_contacts(); ++c)
        CHECK((w.block(c, d).col(j) - u.segment<3>(3 * c)).norm() <= 1e-13 * (1 + u.norm()));
    }
}

TEST_CASE("a singular Newton matrix is refused") {
  Array<GrainCompliance<3>> grains(1);
  grains[0] = {{0, 1}, {1, 1}, Eigen::MatrixXd::Zero(6, 6)};
  const GrainComplianceDelassus<3> w(2, std::move(grains));
  NewtonMatrix<GrainComplianceDelassus<3>> matrix(w);
  const Array<Eigen::Matrix3d> a(2, Eigen::Matrix3d::Identity()), zero(2, Eigen::Matrix3d::Zero());
  Eigen::VectorXd x = Eigen::VectorXd::Ones(6);
  CHECK_FALSE(matrix.solve(Array<int>(2, 3), a, zero, x));
}
