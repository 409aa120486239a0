// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <jampack/core/splitmix.hpp>
#include <jampack/problem/grain_compliance_delassus.hpp>
#include <jampack/solver/alart_curnier.hpp>
#include <jampack/solver/local_solver.hpp>
#include <jampack/solver/newton_matrix.hpp>
#include <memory>
#include <type_traits>
#include <utility>

namespace jampack {

/// The contact problem of one proximal step, W r + q + alpha D (r - centre) with D = diag(1/rho_c): sweeps,
/// velocities, natural map and semismooth Newton steps on it (docs/theory/contact_solvers.md, eq. 15 to 17).
/// Matrix says how W is stored and factorised (NewtonMatrix).
template <class Matrix, LocalContactLaw LocalLaw>
class RegularisedProblem {
  using Stored = typename Matrix::Stored;
  static constexpr int N = Stored::n_unknowns;
  using Block = Eigen::Matrix<double, N, N>;
  using Vec = ContactVector<N>;
  using DiagonalBlock = std::remove_cvref_t<decltype(std::declval<const Stored&>().diagonal_block(Index{}))>;

 public:
  RegularisedProblem(const Stored& w, const Eigen::VectorXd& q, const Array<LocalLaw>& law,
                     const Array<double>& rho, Threads threads = {})
      : w_(w),
        threads_(threads),
        q_(q),
        law_(law),
        rho_(rho),
        n_(law.size()),
        shift_(n_, 0.0),
        step_(rho),
        centre_(Eigen::VectorXd::Zero(q.size())),
        local_(n_),
        motion_(w.motion(centre_)),
        n_rows_(n_),
        factor_(n_),
        constant_(n_) {
    for (Index c = 0; c < n_; ++c) order_.push_back(c);
  }

  /// Fixes alpha >= 0 and the centre.
  void regularise(double alpha, const Eigen::VectorXd& centre) {
    centre_ = centre;
    if (alpha == alpha_) return;
    alpha_ = alpha;
    for (Index c = 0; c < n_; ++c) {
      shift_[c] = alpha / rho_[c];
      step_[c] = rho_[c] / (1 + alpha);
      local_[c] = LocalSolver<N, DiagonalBlock>(shifted(w_.diagonal_block(c), shift_[c]));
    }
  }

  /// Velocities in the regularised problem.
  void velocity(const Eigen::VectorXd& r, Eigen::VectorXd& u) const {
    w_.apply(r, u);
    for (Index c = 0; c < n_; ++c) u.template segment<N>(N * c) += rest(r, c);
  }

  /// Norm of the natural map of the regularised problem, in the units of r.
  double error(const Eigen::VectorXd& r, const Eigen::VectorXd& u) const {
    double sum = 0;
    for (Index c = 0; c < n_; ++c)
      sum += natural_map<N>(law_[c], Vec(r.template segment<N>(N * c)), Vec(u.template segment<N>(N * c)),
                            step_[c])
                 .squaredNorm();
    return std::sqrt(sum);
  }

  void sweep(Eigen::VectorXd& r, Index n_sweeps) {
    motion_ = w_.motion(r);
    for (Index k = 0; k < n_sweeps; ++k) {
      if constexpr (in_random_order) shuffle(order_, random_);
      for (const Index c : order_) update(c, r);
    }
  }

  void project(Eigen::VectorXd& r) const {
    for (Index c = 0; c < n_; ++c)
      r.template segment<N>(N * c) =
          project_on_friction_cone<N>(Vec(r.template segment<N>(N * c)), law_[c].friction);
  }

  /// Newton step dr on the Alart–Curnier function from r with velocities u. Reactions of open contacts and
  /// tangential ones without friction go to zero and leave the system. False if it cannot be solved.
  bool newton_step(const Eigen::VectorXd& r, const Eigen::VectorXd& u, Eigen::VectorXd& dr) {
    if (!matrix_) matrix_ = std::make_unique<Matrix>(w_, threads_);
    Eigen::VectorXd gone = r, lost;
    for (Index c = 0; c < n_; ++c) {
      const auto row = alart_curnier_row<N>(law_[c], Vec(r.template segment<N>(N * c)),
                                            Vec(u.template segment<N>(N * c)), step_[c]);
      n_rows_[c] = row.n_rows;
      factor_[c] = row.a;
      constant_[c] = row.c + shift_[c] * row.a;
      dr.template segment<N>(N * c) = row.b;
      gone.template segment<N>(N * c).head(n_rows_[c]).setZero();
    }
    // The right-hand side keeps what they take away.
    if (gone.isZero(0))
      lost = gone;
    else
      w_.apply(gone, lost);
    for (Index c = 0; c < n_; ++c) {
      const int kept = n_rows_[c];
      dr.template segment<N>(N * c).tail(N - kept) = -r.template segment<N>(N * c).tail(N - kept);
      if (kept > 0)
        dr.template segment<N>(N * c).head(kept) += (factor_[c] * lost.template segment<N>(N * c)).head(kept);
    }
    return matrix_->solve(n_rows_, factor_, constant_, dr);
  }

 private:
  /// Between deformable grains sweeps in any fixed order need many times as many
  /// (docs/results/solvers.md).
  static constexpr bool in_random_order = std::is_same_v<Stored, GrainComplianceDelassus<N>>;

  void update(Index c, Eigen::VectorXd& r) {
    const Vec old = r.template segment<N>(N * c);
    const Vec next = local_[c].template solve<SlipAccuracy::for_a_sweep>(
        law_[c], Vec(w_.velocity(motion_, r, c) + rest(r, c)), old);
    if (next == old) return;
    r.template segment<N>(N * c) = next;
    w_.change(motion_, c, Vec(next - old));
  }

  /// What velocity has besides W r.
  Vec rest(const Eigen::VectorXd& r, Index c) const {
    return q_.template segment<N>(N * c) +
           shift_[c] * (r.template segment<N>(N * c) - centre_.template segment<N>(N * c));
  }

  const Stored& w_;
  Threads threads_;
  const Eigen::VectorXd& q_;
  const Array<LocalLaw>& law_;
  const Array<double>& rho_;
  Index n_;
  double alpha_ = -1;
  Array<double> shift_, step_;
  Eigen::VectorXd centre_;
  Array<LocalSolver<N, DiagonalBlock>> local_;
  typename Stored::Motion motion_;
  Array<Index> order_;  ///< of a sweep
  std::uint64_t random_ = 1;
  Array<int> n_rows_;  ///< of each contact in the linear system
  Array<Block> factor_, constant_;
  std::unique_ptr<Matrix> matrix_;
};

}  // namespace jampack
