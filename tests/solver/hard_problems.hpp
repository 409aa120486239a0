// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <jampack/geometry/frame.hpp>
#include <jampack/law/signorini.hpp>
#include <jampack/law/signorini_coulomb.hpp>
#include <jampack/problem/contact_problem.hpp>
#include <jampack/problem/rigid_balls_delassus.hpp>
#include <type_traits>

/// Contact problems that are hard for solvers and whose answers are known.
namespace jampack_tests {

using jampack::Array;
using jampack::Index;

/// A vector of these values.
inline Eigen::VectorXd vector_of(std::initializer_list<double> values) {
  Eigen::VectorXd v(static_cast<Index>(values.size()));
  std::copy(values.begin(), values.end(), v.data());
  return v;
}

/// n balls in a row between a wall at the left and a push of the given impulse at the right: every contact
/// carries the impulse.
template <int N>
auto chain(Index n, double impulse, double mass_of_last = 1) {
  using namespace jampack;
  Array<InverseInertia> bodies(n, {1, 2.5});
  bodies[n - 1] = {1 / mass_of_last, 2.5 / mass_of_last};
  Array<BallContact<3>> contacts;
  for (Index k = 0; k < n; ++k)  // n from left to right: ball k rests on ball k - 1 or the wall
    contacts.push_back({k, k - 1, contact_frame<3>(Vector<3>(1, 0, 0)), 0.5, 0.5});
  Eigen::VectorXd q = Eigen::VectorXd::Zero(N * n);
  q[N * (n - 1)] = -impulse / mass_of_last;
  RigidBallsDelassus<3, N> delassus(bodies, contacts);
  if constexpr (N == 1)
    return ContactProblem<RigidBallsDelassus<3, N>, Signorini>(delassus, q, Array<Signorini>(n));
  else
    return ContactProblem(delassus, q, Array<SignoriniCoulomb>(n, {0.3}));
}

/// Rigid block (unit mass, moments of inertia 1/6) on n^2 points of a floor, falling at speed 1 and sliding
/// at `slide`; every contact `copies` times. The total impulse is (1, -min(slide, friction), 0).
inline jampack::ContactProblem<jampack::BlockSparseDelassus<3>> block_on_floor(
    int n, double slide, double friction, int copies = 1, double mass = 1, double length = 1,
    double time = 1) {
  using namespace jampack;
  const double unit_speed = length / time;
  Array<Eigen::Matrix<double, 3, 6>> h;
  for (int k = 0; k < n * n * copies; ++k) {
    const int point = k % (n * n);
    const Vector<3> arm =
        length * Vector<3>(-0.5 + point % n / (n - 1.0), -0.5 + point / n / (n - 1.0), -0.5);
    Eigen::Matrix<double, 3, 6> row;  // N = z, T1 = x, T2 = y
    const Matrix<3> axes = (Matrix<3>() << 0, 0, 1, 1, 0, 0, 0, 1, 0).finished();
    row.leftCols<3>() = axes;
    for (int j = 0; j < 3; ++j) row.col(3 + j) = axes * Vector<3>::Unit(j).cross(arm);
    h.push_back(row);
  }
  Eigen::Matrix<double, 6, 1> inverse_mass, v;
  inverse_mass << 1 / mass, 1 / mass, 1 / mass, Vector<3>::Constant(6 / (mass * length * length));
  v << slide * unit_speed, 0, -unit_speed, 0, 0, 0;
  Array<DelassusBlock<3>> blocks;
  Eigen::VectorXd q(3 * h.size());
  for (Index c = 0; c < h.size(); ++c) {
    q.segment<3>(3 * c) = h[c] * v;
    for (Index d = 0; d < h.size(); ++d)
      blocks.push_back({c, d, h[c] * inverse_mass.asDiagonal() * h[d].transpose()});
  }
  return {BlockSparseDelassus<3>(h.size(), blocks), q, Array<SignoriniCoulomb>(h.size(), {friction})};
}

/// A point mass that lands at speed 1 and slides at `slide`: u_T = max(0, slide - friction).
inline jampack::ContactProblem<jampack::BlockSparseDelassus<3>> point_on_floor(double slide,
                                                                               double friction) {
  using namespace jampack;
  return {BlockSparseDelassus<3>(1, {{0, 0, Matrix<3>::Identity()}}),
          vector_of({-1, 0.6 * slide, 0.8 * slide}),
          {{friction}}};
}

/// A ball without rotation in a symmetric groove whose faces stand at `angle` to the vertical, pulled out
/// upwards at speed 1. `prestress` is a first guess of r in which each face pushes by 1000: the ball is
/// locked if friction >= tan(angle), and must leave otherwise.
inline jampack::ContactProblem<jampack::BlockSparseDelassus<2>> wedge(double angle, double friction,
                                                                      Eigen::VectorXd& prestress) {
  using namespace jampack;
  Array<DelassusBlock<2>> blocks;
  Matrix<2> frame[2];
  for (int k = 0; k < 2; ++k)
    frame[k] = contact_frame<2>(Vector<2>((k == 0 ? 1 : -1) * std::cos(angle), std::sin(angle)));
  for (Index c = 0; c < 2; ++c)
    for (Index d = 0; d < 2; ++d) blocks.push_back({c, d, frame[c] * frame[d].transpose()});
  Eigen::VectorXd q(4);
  prestress.resize(4);
  const double push = 1000;
  for (int k = 0; k < 2; ++k) {
    q.segment<2>(2 * k) = frame[k] * Vector<2>(0, 1);
    prestress.segment<2>(2 * k) = frame[k] * Vector<2>((k == 0 ? 1 : -1) * push, -0.5);
  }
  return {BlockSparseDelassus<2>(2, blocks), q, Array<SignoriniCoulomb>(2, {friction})};
}

/// One ball squeezed by two walls that both move inwards: no solution.
inline jampack::ContactProblem<jampack::RigidBallsDelassus<2, 2>> squeezed_ball() {
  using namespace jampack;
  Array<BallContact<2>> contacts = {{0, -1, contact_frame<2>(Vector<2>(1, 0)), 0.5},
                                    {0, -1, contact_frame<2>(Vector<2>(-1, 0)), 0.5}};
  return {RigidBallsDelassus<2, 2>({{1, 2}}, contacts), vector_of({-1, 0, -1, 0}),
          Array<SignoriniCoulomb>(2, {0.3})};
}

/// Sum of the reactions, in the common frame of the contacts.
inline jampack::Vector<3> total(const Eigen::VectorXd& r) {
  jampack::Vector<3> sum = jampack::Vector<3>::Zero();
  for (Index c = 0; c < r.size() / 3; ++c) sum += r.segment<3>(3 * c);
  return sum;
}

}  // namespace jampack_tests
