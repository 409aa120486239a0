// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

namespace jampack {

/// Reactions and velocities of one contact: N components in the order N, T1, T2 (see geometry/frame.hpp).
/// N = 1 is a frictionless contact, whose cone is r_N >= 0.
template <int N>
using ContactVector = Eigen::Matrix<double, N, 1>;

/// Projects z on the Coulomb cone K = {r : |r_T| <= friction r_N} (docs/theory/contact_solvers.md, eq. 3).
/// friction >= 0; for N = 1 it is not used.
template <int N>
ContactVector<N> project_on_friction_cone(const ContactVector<N>& z, double friction) {
  ContactVector<N> r;
  if constexpr (N == 1) {
    r[0] = z[0] > 0 ? z[0] : 0.0;
  } else {
    const double normal = z[0];
    const double tangential = z.template tail<N - 1>().norm();
    // The polar cone first: at friction 0 a pull along -n satisfies both conditions.
    if (friction * tangential <= -normal) return ContactVector<N>::Zero();
    if (tangential <= friction * normal) return z;
    const double projected = (friction * tangential + normal) / (1 + friction * friction);
    r[0] = projected;
    r.template tail<N - 1>() = (friction * projected / tangential) * z.template tail<N - 1>();
  }
  return r;
}

/// Is r in the cone, up to `slack` in the units of r?
template <int N>
bool in_friction_cone(const ContactVector<N>& r, double friction, double slack = 0) {
  if constexpr (N == 1)
    return r[0] >= -slack;
  else
    return r.template tail<N - 1>().norm() <= friction * r[0] + slack;
}

/// Is u in the dual cone {u : u . r >= 0 for every r in K} = {u : u_N >= friction |u_T|}, up to `slack`?
template <int N>
bool in_dual_cone(const ContactVector<N>& u, double friction, double slack = 0) {
  if constexpr (N == 1)
    return u[0] >= -slack;
  else
    return u[0] + slack >= friction * u.template tail<N - 1>().norm();
}

/// De Saxcé's velocity u + (friction |u_T|, 0, 0): Coulomb's law with unilateral contact is
/// K in r, perpendicular to it, in K* (docs/theory/contact_solvers.md, eq. 2).
template <int N>
ContactVector<N> de_saxce_velocity(const ContactVector<N>& u, double friction) {
  ContactVector<N> result = u;
  if constexpr (N > 1) result[0] += friction * u.template tail<N - 1>().norm();
  return result;
}

}  // namespace jampack
