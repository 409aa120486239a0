// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace jampack {

/// Reactions and velocities of one contact: N components in the order N, T1, T2 (see geometry/frame.hpp).
/// N = 1 is a frictionless contact, whose cone is r_N >= 0.
template <int N>
using ContactVector = Eigen::Matrix<double, N, 1>;

/// |z_T|, 0 for N = 1. By elements: a vector load of elements just stored one by one waits for the stores,
/// and this is in every update of a contact.
template <int N>
double tangential_norm(const ContactVector<N>& z) {
  if constexpr (N == 1) return 0;
  if constexpr (N == 2) return std::abs(z[1]);
  if constexpr (N == 3) return std::sqrt(z[1] * z[1] + z[2] * z[2]);
}

/// Projects z on the Coulomb cone K = {r : |r_T| <= friction r_N} (docs/theory/contact_solvers.md, eq. 3).
/// friction >= 0; for N = 1 it is not used.
template <int N>
[[gnu::always_inline]] inline ContactVector<N> project_on_friction_cone(const ContactVector<N>& z,
                                                                        double friction) {
  ContactVector<N> r;
  if constexpr (N == 1) {
    r[0] = z[0] > 0 ? z[0] : 0.0;
  } else {
    const double normal = z[0], tangential = tangential_norm<N>(z);
    const double projected = (friction * tangential + normal) / (1 + friction * friction);
    // The polar cone first: at friction 0 a pull along -n satisfies both conditions. All three cases are
    // computed and one is selected: branches would not be foreseen.
    const bool in_polar = friction * tangential <= -normal, in_cone = tangential <= friction * normal;
    const double factor = in_polar ? 0.0 : in_cone ? 1.0 : friction * projected / tangential;
    r[0] = in_polar ? 0.0 : in_cone ? normal : projected;
    r[1] = factor * z[1];
    if constexpr (N > 2) r[2] = factor * z[2];
  }
  return r;
}

/// Is r in the cone, up to `slack` in the units of r?
template <int N>
bool in_friction_cone(const ContactVector<N>& r, double friction, double slack = 0) {
  if constexpr (N == 1)
    return r[0] >= -slack;
  else
    return tangential_norm<N>(r) <= friction * r[0] + slack;
}

/// Is u in the dual cone {u : u . r >= 0 for every r in K} = {u : u_N >= friction |u_T|}, up to `slack`?
template <int N>
bool in_dual_cone(const ContactVector<N>& u, double friction, double slack = 0) {
  if constexpr (N == 1)
    return u[0] >= -slack;
  else
    return u[0] + slack >= friction * tangential_norm<N>(u);
}

/// De Saxcé's velocity u + (friction |u_T|, 0, 0): Coulomb's law with unilateral contact is
/// K in r, perpendicular to it, in K* (docs/theory/contact_solvers.md, eq. 2).
template <int N>
ContactVector<N> de_saxce_velocity(const ContactVector<N>& u, double friction) {
  ContactVector<N> result = u;
  if constexpr (N > 1) result[0] += friction * tangential_norm<N>(u);
  return result;
}

}  // namespace jampack
