// SPDX-License-Identifier: MIT
#include <Eigen/Dense>
#include <jampack/problem/grain_compliance_delassus.hpp>
#include <jampack/problem/rigid_balls_delassus.hpp>
#include <jampack/problem/stored_blocks.hpp>
#include <random>

#include "../catch.hpp"

using namespace jampack;

namespace {

template <class Delassus>
Eigen::MatrixXd dense(const Delassus& delassus) {
  const Index n = Delassus::n_unknowns * delassus.n_contacts();
  Eigen::MatrixXd w(n, n);
  Eigen::VectorXd column;
  for (Index j = 0; j < n; ++j) {
    delassus.apply(Eigen::VectorXd::Unit(n, j), column);
    w.col(j) = column;
  }
  return w;
}

// What every form must satisfy: diagonal blocks, motions changed step by step and stored blocks agree with W.
template <class Delassus>
void check_consistent(const Delassus& delassus) {
  constexpr int N = Delassus::n_unknowns;
  const Eigen::MatrixXd w = dense(delassus);
  const double size = w.cwiseAbs().maxCoeff();
  REQUIRE(size > 0);
  Eigen::VectorXd r = Eigen::VectorXd::Zero(w.rows());
  auto motion = delassus.motion(r);
  for (Index c = 0; c < delassus.n_contacts(); ++c) {
    CHECK((full_block<N>(delassus.diagonal_block(c)) - w.block<N, N>(N * c, N * c)).norm() <= 1e-14 * size);
    const ContactVector<N> change = ContactVector<N>::Constant(0.5 + static_cast<double>(c));
    r.segment<N>(N * c) += change;
    delassus.change(motion, c, change);
  }
  const Eigen::VectorXd u = w * r;
  for (Index c = 0; c < delassus.n_contacts(); ++c)
    CHECK((delassus.velocity(motion, r, c) - u.segment<N>(N * c)).norm() <= 1e-13 * u.norm());
  CHECK((dense(as_block_sparse(delassus)) - w).norm() <= 1e-14 * w.norm());
}

}  // namespace

TEMPLATE_TEST_CASE_SIG("Block-sparse rows, long and short runs, give back the dense matrix", "", ((int N), N),
                       1, 2, 3) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const Index n = 40;
  Eigen::MatrixXd w = Eigen::MatrixXd::Zero(N * n, N * n);
  Array<DelassusBlock<N>> blocks;
  for (Index c = 0; c < n; ++c)
    for (Index d = 0; d < n; ++d)
      if (c == d || c < 5 || (c + d) % 7 == 0 || (c > 30 && d > 20 && d < 24)) {
        Eigen::Matrix<double, N, N> block;
        for (Index i = 0; i < block.size(); ++i) block.data()[i] = normal(random);
        w.template block<N, N>(N * c, N * d) = block;
        blocks.push_back({c, d, block});
      }
  std::shuffle(blocks.begin(), blocks.end(), random);
  const BlockSparseDelassus<N> delassus(n, blocks);
  CHECK((dense(delassus) - w).norm() <= 1e-14 * w.norm());
  CHECK(delassus.n_stored() == N * N * blocks.size());
  check_consistent(delassus);
}

TEST_CASE("A large operator of 2 x 2 blocks, given in any order") {
  constexpr Index n = 5000;
  Array<DelassusBlock<2>> blocks;
  for (Index c = n - 1; c >= 0; --c)
    for (const Index d : {c, (c + 7) % n, (c + 500) % n})
      blocks.push_back({c, d, Matrix<2>::Constant(static_cast<double>(c - d))});
  const BlockSparseDelassus<2> delassus(n, blocks);
  Eigen::VectorXd u;
  delassus.apply(Eigen::VectorXd::Ones(2 * n), u);
  CHECK(u[0] == 2.0 * (-7 - 500));
  CHECK(u[2 * n - 1] == 2.0 * (n - 7 + n - 500));
}

TEMPLATE_TEST_CASE_SIG("Rigid balls: the matrix-free operator is H M^-1 H^T", "", ((int Dim, int N), Dim, N),
                       (2, 1), (2, 2), (3, 1), (3, 3)) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const Index n_balls = 5;
  Array<InverseInertia> bodies(n_balls);
  for (Index b = 0; b < n_balls; ++b)
    bodies[b] = {1.0 + static_cast<double>(b), 2.5 * (1.0 + static_cast<double>(b))};
  Array<BallContact<Dim>> contacts;
  for (Index k = 0; k < 9; ++k) {
    Vector<Dim> n;
    for (int i = 0; i < Dim; ++i) n[i] = normal(random);
    const Index a = k % n_balls, b = k < 7 ? (k + 2) % n_balls : -1;
    contacts.push_back(
        {a, b, contact_frame<Dim>(n.normalized()), 0.5 + 0.1 * static_cast<double>(k), 0.4, b < 0 ? 1.5 : 0});
  }
  const double mode = 0.7;
  const RigidBallsDelassus<Dim, N> delassus(bodies, contacts, mode);
  // H row by row from v + omega x lever, by its definition.
  constexpr Index spins = Spin<Dim>::RowsAtCompileTime, dof = Dim + spins;
  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(N * contacts.size(), dof * n_balls + 1),
                  m = Eigen::MatrixXd::Zero(h.cols(), h.cols());
  const auto add = [&](Index c, Index body, const Vector<Dim>& lever, double sign) {
    for (Index j = 0; j < dof; ++j) {
      Vector<Dim> v = Vector<Dim>::Zero();
      if (j < Dim)
        v[j] = 1;
      else if constexpr (Dim == 2)
        v = Vector<2>(-lever[1], lever[0]);
      else
        v = Vector<3>::Unit(j - Dim).cross(lever);
      h.block(N * c, dof * body + j, N, 1) += sign * (contacts[c].frame * v).template head<N>();
    }
  };
  for (Index c = 0; c < contacts.size(); ++c) {
    const Vector<Dim> n = contacts[c].frame.row(0).transpose();
    add(c, contacts[c].candidate, -contacts[c].candidate_arm * n, 1);
    if (contacts[c].antagonist >= 0)
      add(c, contacts[c].antagonist, contacts[c].antagonist_arm * n, -1);
    else
      h(N * c, h.cols() - 1) = -contacts[c].wall_rate;
  }
  for (Index b = 0; b < n_balls; ++b)
    for (Index j = 0; j < dof; ++j) m(dof * b + j, dof * b + j) = j < Dim ? bodies[b].mass : bodies[b].spin;
  m(m.rows() - 1, m.rows() - 1) = mode;
  const Eigen::MatrixXd expected = h * m * h.transpose();
  CHECK((dense(delassus) - expected).norm() <= 1e-14 * expected.norm());
  check_consistent(delassus);
}

TEST_CASE("One dense compliance a grain: W is the sum over grains") {
  const Index n = 6;
  Array<GrainCompliance<3>> grains(3);
  grains[0].contact = {0, 1, 2, 3};
  grains[1].contact = {2, 3, 4};
  grains[2].contact = {4, 5, 0};
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  for (Index g = 0; g < 3; ++g) {
    auto& grain = grains[g];
    const Index width = 3 * grain.contact.size();
    const Eigen::MatrixXd a = Eigen::MatrixXd::Random(width, width);
    grain.compliance = a * a.transpose();
    for (Index i = 0; i < grain.contact.size(); ++i) grain.sign.push_back((i + g) % 2 == 0 ? 1 : -1);
    for (Index i = 0; i < grain.contact.size(); ++i)
      for (Index j = 0; j < grain.contact.size(); ++j)
        expected.block<3, 3>(3 * grain.contact[i], 3 * grain.contact[j]) +=
            grain.sign[i] * grain.sign[j] * grain.compliance.block<3, 3>(3 * i, 3 * j);
  }
  const GrainComplianceDelassus<3> delassus(n, grains);
  CHECK((dense(delassus) - expected).norm() <= 1e-14 * expected.norm());
  check_consistent(delassus);
}

TEST_CASE("Contacts without friction bring one row each into a grain's compliance") {
  // Contact 1 has its normal unknown only: W with its tangential rows and columns left out.
  Eigen::MatrixXd full[2];
  for (auto& c : full) {
    const Eigen::MatrixXd a = Eigen::MatrixXd::Random(6, 6);
    c = a * a.transpose();
  }
  Array<GrainCompliance<3>> whole(2), reduced(2);
  const Eigen::Vector4i kept(0, 1, 2, 3);
  for (Index g = 0; g < 2; ++g) {
    whole[g] = {{0, 1}, {1, g == 0 ? 1.0 : -1.0}, full[g]};
    reduced[g] = {{0, 1}, {1, g == 0 ? 1.0 : -1.0}, full[g](kept, kept), {3, 1}};
  }
  const GrainComplianceDelassus<3> all(2, whole), few(2, reduced);
  Eigen::MatrixXd expected = dense(all);
  for (const Index i : {4, 5}) {
    expected.row(i).setZero();
    expected.col(i).setZero();
  }
  CHECK(few.n_stored() == 2 * 4 * 4);
  CHECK(few.n_rows(0) == 3);
  CHECK(few.n_rows(1) == 1);
  CHECK((dense(few) - expected).norm() <= 1e-14 * expected.norm());
  CHECK((dense(as_block_sparse(few)) - expected).norm() <= 1e-14 * expected.norm());
  for (const Index c : {0, 1})
    for (const Index d : {0, 1})
      CHECK((few.block(c, d) - expected.block<3, 3>(3 * c, 3 * d)).norm() <= 1e-14 * expected.norm());
  CHECK(few.diagonal_block(1)(0, 0) == expected(3, 3));
  Eigen::VectorXd r = Eigen::VectorXd::Zero(6);
  auto motion = few.motion(r);
  for (Index c = 0; c < 2; ++c) {
    const ContactVector<3> change(1, c == 0 ? 2 : 0, c == 0 ? 3 : 0);
    r.segment<3>(3 * c) += change;
    few.change(motion, c, change);
  }
  for (Index c = 0; c < 2; ++c)
    CHECK((few.velocity(motion, r, c) - expected.middleRows<3>(3 * c) * r).norm() <= 1e-13 * r.norm());

  reduced[1].n_rows = {3, 3};
  reduced[1].compliance = full[1];
  CHECK_THROWS_AS(GrainComplianceDelassus<3>(2, reduced), InvalidInput);
}

TEST_CASE("Impossible operators are refused") {
  CHECK_THROWS_AS(BlockSparseDelassus<2>(1, {{0, 1, Matrix<2>::Identity()}}), InvalidInput);
  CHECK_THROWS_AS(BlockSparseDelassus<2>(1, {{0, 0, Matrix<2>::Constant(std::nan(""))}}), InvalidInput);
  CHECK_THROWS_AS((RigidBallsDelassus<2, 2>({{1, 1}}, {{3, -1, Matrix<2>::Identity(), 1.0}})), InvalidInput);
  CHECK_THROWS_AS((RigidBallsDelassus<2, 2>({{-1, 1}}, {})), InvalidInput);
}

TEST_CASE("Aligned scalars begin a cache line, are zero when new and keep their values") {
  AlignedScalars scalars;
  CHECK(scalars.data() == nullptr);
  for (const Index n : {1, 8, 9, 1000}) {
    const double kept = scalars.data() == nullptr ? 0 : scalars.data()[0];
    scalars.resize(n);
    CHECK(reinterpret_cast<std::uintptr_t>(scalars.data()) % 64 == 0);
    CHECK(scalars.data()[0] == kept);
    CHECK(scalars.data()[AlignedScalars::padded(n) - 1] == 0);
    scalars.data()[0] = static_cast<double>(n);
  }
  CHECK(AlignedScalars::padded(0) == 0);
  CHECK(AlignedScalars::padded(9) == 16);
}
