// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/problem/contact_problem.hpp>

namespace jampack {

/// One contact in Newton's method on the Alart–Curnier function, A du + C dr = b
/// (docs/theory/contact_solvers.md, eq. 16 and 17). Only its first n_rows unknowns take part: none where it
/// is open, one without friction; the others, and with them dr = b = -r, are gone.
template <int N>
struct AlartCurnierRow {
  int n_rows = 0;
  Eigen::Matrix<double, N, N> a = Eigen::Matrix<double, N, N>::Identity();
  Eigen::Matrix<double, N, N> c = Eigen::Matrix<double, N, N>::Zero();
  ContactVector<N> b;

  /// The part of v that takes part, zero where it is gone.
  ContactVector<N> kept(const ContactVector<N>& v) const {
    ContactVector<N> part;
    for (int i = 0; i < N; ++i) part[i] = i < n_rows ? v[i] : 0.0;
    return part;
  }
};

/// At reactions r and velocities u, with the step rho > 0 of the natural map.
template <int N, LocalContactLaw LocalLaw>
AlartCurnierRow<N> alart_curnier_row(const LocalLaw& law, const ContactVector<N>& r,
                                     const ContactVector<N>& u, double rho) {
  AlartCurnierRow<N> row;
  double normal_velocity = u[0], softness = 0;
  if constexpr (LocalLaw::is_compliant) {
    normal_velocity += law.compliance(r[0]);
    softness = r[0] > 0 ? law.compliance_slope(r[0]) : 0;
  }
  row.b = -r;
  const double normal = r[0] - rho * normal_velocity, friction = law.friction;
  if (!(normal > 0)) return row;
  row.n_rows = friction > 0 ? N : 1;
  row.c(0, 0) = softness;
  row.b[0] = -normal_velocity;
  if constexpr (N > 1) {
    if (!(friction > 0)) return row;
    row.b = -u;
    row.b[0] = -normal_velocity;
    using Tangential = Eigen::Matrix<double, N - 1, 1>;
    using Block = Eigen::Matrix<double, N - 1, N - 1>;
    const Tangential v = (r - rho * u).template tail<N - 1>();
    const double size = v.norm();
    if (size > friction * normal) {  // slipping
      const Tangential e = v / size;
      const Block turn = (friction * normal / size) * (Block::Identity() - e * e.transpose());
      row.a.template bottomRightCorner<N - 1, N - 1>() = turn;
      row.c.template bottomRightCorner<N - 1, N - 1>() = (Block::Identity() - turn) / rho;
      row.c.template bottomLeftCorner<N - 1, 1>() = -friction / rho * e;
      row.b.template tail<N - 1>() = (friction * r[0] * e + turn * v - r.template tail<N - 1>()) / rho;
    }
  }
  return row;
}

}  // namespace jampack
