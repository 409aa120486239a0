// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <jampack/core/dimension.hpp>

namespace jampack {

/// The sign convention, stated here once for the whole library.
///
/// A contact joins a *candidate* body to an *antagonist* body (or wall). The unit normal n points from the
/// antagonist to the candidate, so the gap is positive when they are apart and its rate is the normal
/// relative velocity u_N = n . (v_candidate - v_antagonist). The reaction r acts on the candidate, -r on the
/// antagonist; r_N >= 0 pushes them apart. Local components are ordered N, T1, T2 (N, T in 2D) and
/// (n, t1, t2) is right-handed.
///
/// Rows are the axes: local = frame * global, global = frame^T * local.
template <int Dim>
using Frame = Matrix<Dim>;

/// Right-handed orthonormal frame whose first row is the unit vector n; a smooth function of n but for the
/// unavoidable branch at n_z = 0 (Duff et al., "Building an orthonormal basis, revisited", JCGT 2017).
template <int Dim>
Frame<Dim> contact_frame(const Vector<Dim>& n) {
  Frame<Dim> frame;
  if constexpr (Dim == 2) {
    frame << n[0], n[1], -n[1], n[0];
  } else {
    const double sign = std::copysign(1.0, n[2]);
    const double a = -1.0 / (sign + n[2]);
    const double b = n[0] * n[1] * a;
    frame.row(0) = n;
    frame.row(1) << 1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0];
    frame.row(2) << b, sign + n[1] * n[1] * a, -n[1];
  }
  return frame;
}

}  // namespace jampack
