// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <jampack/core/dimension.hpp>

namespace jampack {

/// Von Mises stress sqrt(3/2 s:s) of a symmetric Cauchy stress, s its deviator.
inline double von_mises(const Matrix<3>& stress) {
  const Matrix<3> deviator = stress - stress.trace() / 3 * Matrix<3>::Identity();
  return std::sqrt(1.5) * deviator.norm();
}

/// In plane strain the stress out of the plane is not zero and belongs in it: lambda ln(J) / J for the
/// compressible neo-Hookean solid, nu (s_xx + s_yy) for the linear elastic one.
inline double von_mises(const Matrix<2>& stress, double out_of_plane) {
  Matrix<3> full = Matrix<3>::Zero();
  full.topLeftCorner<2, 2>() = stress;
  full(2, 2) = out_of_plane;
  return von_mises(full);
}

}  // namespace jampack
