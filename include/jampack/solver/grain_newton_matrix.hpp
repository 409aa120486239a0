// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/solver/grain_newton_gmres.hpp>
#include <jampack/solver/multifrontal_lu.hpp>
#include <jampack/solver/newton_matrix.hpp>

namespace jampack {

/// The same between deformable grains: by GMRES where that is estimated to cost less than factors, by factors
/// otherwise and where it does not converge.
template <int N>
class NewtonMatrix<GrainComplianceDelassus<N>> {
 public:
  using Stored = GrainComplianceDelassus<N>;
  using Block = Eigen::Matrix<double, N, N>;
  static const Stored& stored(const Stored& w) { return w; }

  /// GMRES stands in for factors wherever it is cheaper: less than any patience with sweeps.
  static Index factorisation_in_sweeps(const Stored&) { return 0; }

  double tolerance = 1e-3;  ///< |b - M x| / |b| that GMRES has to reach: a step that needs no more

  /// `w` must outlive the matrix.
  explicit NewtonMatrix(const Stored& w, Threads threads = {})
      : groups_(group_contacts(w)), factors_(w, groups_, threads), gmres_(w, groups_, threads) {}

  bool solve(const Array<int>& n_rows, const Array<Block>& a, const Array<Block>& constant,
             Eigen::VectorXd& x) {
    if (gmres_.work(n_rows) < factors_.work(n_rows) && gmres_.solve(n_rows, a, constant, tolerance, x))
      return true;
    return factors_.solve(n_rows, a, constant, x);
  }

  /// Makes precondition() an approximation of the inverse, or the inverse where factors cost less. False if
  /// there is none.
  bool prepare(const Array<int>& n_rows, const Array<Block>& a, const Array<Block>& constant) {
    by_factors_ = factors_.work(n_rows) <= gmres_.work(n_rows);
    return by_factors_ ? factors_.factorise(n_rows, a, constant) : gmres_.prepare(n_rows, a, constant);
  }
  /// Of a right-hand side; unknowns that do not take part stay as they are.
  void precondition(Eigen::VectorXd& x) const {
    by_factors_ ? factors_.substitute(x) : gmres_.precondition(x);
  }

 private:
  bool by_factors_ = false;
  Array<ContactGroup> groups_;
  MultifrontalLU<N> factors_;
  GrainNewtonGmres<N> gmres_;
};

}  // namespace jampack
