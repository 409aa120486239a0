// SPDX-License-Identifier: MIT
#include <Eigen/LU>
#include <jampack/solver/grain_newton_matrix.hpp>
#include <random>

#include "../catch.hpp"

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

template <int N>
void check(Threads threads) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const auto w = random_grains<N>(9, random);
  const Index n = w.n_contacts();
  using Block = Eigen::Matrix<double, N, N>;
  Array<Block> a, constant;
  Array<int> n_rows;
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(N * n, N * n);
  for (Index c = 0; c < n; ++c) {
    a.push_back(Block::NullaryExpr([&] { return normal(random); }));
    constant.push_back(3 * Block::Identity());
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
  const Eigen::VectorXd b = Eigen::VectorXd::NullaryExpr(N * n, [&] { return normal(random); });
  const Eigen::VectorXd x = dense.partialPivLu().solve(b);

  NewtonMatrix<GrainComplianceDelassus<N>> of_grains(w, threads);
  const auto groups = group_contacts(w);
  MultifrontalLU<N> factors(w, groups, threads);
  GrainNewtonGmres<N> gmres(w, groups, threads);
  const auto stored = as_block_sparse(w);
  NewtonMatrix<BlockSparseDelassus<N>> of_blocks(stored);
  const auto error = [&](auto solve) {
    Eigen::VectorXd y = b;
    REQUIRE(solve(y));
    return (y - x).norm() / x.norm();
  };
  for (int again = 0; again < 2; ++again) {  // what was set up is used again
    CHECK(error([&](auto& y) { return factors.solve(n_rows, a, constant, y); }) <= 1e-10);
    CHECK(error([&](auto& y) { return gmres.solve(n_rows, a, constant, 1e-11, y); }) <= 1e-9);
    CHECK(error([&](auto& y) { return of_grains.solve(n_rows, a, constant, y); }) <= 1e-2);
    CHECK(error([&](auto& y) {
            if (!of_grains.prepare(n_rows, a, constant)) return false;
            of_grains.precondition(y);
            return true;
          }) <= 1e-10);  // so few contacts are left to factors
    // Grains of at most sixteen unknowns are all modes: the two levels together are exact.
    if (N == 1)
      CHECK(error([&](auto& y) {
              if (!gmres.prepare(n_rows, a, constant)) return false;
              gmres.precondition(y);
              return true;
            }) <= 1e-6);
    CHECK(error([&](auto& y) { return of_blocks.solve(n_rows, a, constant, y); }) <= 1e-8);
  }
}

}  // namespace

TEST_CASE("the factors of the Newton matrix solve as a dense matrix does") {
  check<1>({});
  check<2>({});
  check<3>({});
  check<3>({.count = 2});
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
