// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <jampack/problem/block_sparse_delassus.hpp>
#include <jampack/solver/block_sparse_lu.hpp>
#include <jampack/solver/local_solver.hpp>
#include <type_traits>

namespace jampack {

/// The contact problem of one proximal step, W r + q + alpha D (r - centre) with D = diag(1/rho_c): sweeps,
/// velocities, natural map and semismooth Newton steps on it (docs/theory/contact_solvers.md, eq. 15 to 17).
/// Everything is allocated when it is made. W is held as stored blocks.
template <int N, LocalContactLaw LocalLaw>
class RegularisedProblem {
  using Block = Eigen::Matrix<double, N, N>;
  using Vec = ContactVector<N>;

 public:
  RegularisedProblem(const BlockSparseDelassus<N>& w, const Eigen::VectorXd& q, const Array<LocalLaw>& law,
                     const Array<double>& rho)
      : w_(w),
        q_(q),
        law_(law),
        rho_(rho),
        n_(law.size()),
        shift_(n_, 0.0),
        step_(rho),
        centre_(Eigen::VectorXd::Zero(q.size())),
        local_(n_),
        factor_(n_),
        constant_(n_) {}

  /// Fixes alpha >= 0 and the centre.
  void regularise(double alpha, const Eigen::VectorXd& centre) {
    centre_ = centre;
    if (alpha == alpha_) return;
    alpha_ = alpha;
    for (Index c = 0; c < n_; ++c) {
      shift_[c] = alpha / rho_[c];
      step_[c] = rho_[c] / (1 + alpha);
      local_[c] = LocalSolver<N>(w_.diagonal_block(c) + shift_[c] * Block::Identity());
    }
  }

  /// Velocity of contact c in the regularised problem.
  Vec velocity(const Eigen::VectorXd& r, Index c) const {
    return w_.velocity({}, r, c) + q_.template segment<N>(N * c) +
           shift_[c] * (r.template segment<N>(N * c) - centre_.template segment<N>(N * c));
  }
  void velocity(const Eigen::VectorXd& r, Eigen::VectorXd& u) const {
    for (Index c = 0; c < n_; ++c) u.template segment<N>(N * c) = velocity(r, c);
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

  void sweep(Eigen::VectorXd& r) const {
    for (Index c = 0; c < n_; ++c)
      r.template segment<N>(N * c) =
          local_[c].solve(law_[c], velocity(r, c), Vec(r.template segment<N>(N * c)));
  }

  void project(Eigen::VectorXd& r) const {
    for (Index c = 0; c < n_; ++c)
      r.template segment<N>(N * c) =
          project_on_friction_cone<N>(Vec(r.template segment<N>(N * c)), law_[c].friction);
  }

  /// Newton step dr on the Alart–Curnier function from r with velocities u. Open contacts go to zero and
  /// leave the system. False if the system cannot be solved.
  bool newton_step(const Eigen::VectorXd& r, const Eigen::VectorXd& u, Eigen::VectorXd& dr) {
    if (!analysed_) analyse();
    for (Index c = 0; c < n_; ++c)
      dr.template segment<N>(N * c) =
          linearise(c, Vec(r.template segment<N>(N * c)), Vec(u.template segment<N>(N * c)));
    // The right-hand side keeps what open contacts take away: A W_cd r_d.
    const bool solved = lu_.factorise([&](Index c, auto add) {
      if (open_[c]) {
        add(c, Block::Identity());
        return;
      }
      w_.for_each_block(c, [&](Index d, const Block& block) {
        if (open_[d])
          dr.template segment<N>(N * c) += factor_[c] * (block * r.template segment<N>(N * d));
        else
          add(d, Block(factor_[c] * block));
      });
      add(c, Block(shift_[c] * factor_[c] + constant_[c]));
    });
    if (!solved) return false;
    lu_.solve(dr);
    return dr.allFinite();
  }

 private:
  void analyse() {
    lu_.analyse(symmetric_pattern(w_));
    open_.assign(n_, 0);
    analysed_ = true;
  }

  // One row of the linear system, A (du) + C dr = b: sets A and C, returns b. For an open contact b = -r.
  Vec linearise(Index c, const Vec& r, const Vec& u) {
    const double rho = step_[c], friction = law_[c].friction;
    double normal_velocity = u[0], softness = 0;
    if constexpr (LocalLaw::is_compliant) {
      normal_velocity += law_[c].compliance(r[0]);
      softness = r[0] > 0 ? law_[c].compliance_slope(r[0]) : 0;
    }
    const double normal = r[0] - rho * normal_velocity;
    open_[c] = !(normal > 0);
    if (open_[c]) return -r;
    Block& a = factor_[c];
    Block& k = constant_[c];
    a.setIdentity();
    k.setZero();
    k(0, 0) = softness;
    Vec b = -u;
    b[0] = -normal_velocity;
    if constexpr (N > 1) {
      using Tangential = Eigen::Matrix<double, N - 1, 1>;
      using TangentialBlock = Eigen::Matrix<double, N - 1, N - 1>;
      const Tangential v = (r - rho * u).template tail<N - 1>();
      const double size = v.norm();
      if (size > friction * normal) {  // slipping
        const Tangential e = v / size;
        const TangentialBlock turn =
            (friction * normal / size) * (TangentialBlock::Identity() - e * e.transpose());
        a.template bottomRightCorner<N - 1, N - 1>() = turn;
        k.template bottomRightCorner<N - 1, N - 1>() = (TangentialBlock::Identity() - turn) / rho;
        k.template bottomLeftCorner<N - 1, 1>() = -friction / rho * e;
        b.template tail<N - 1>() = (friction * r[0] * e + turn * v - r.template tail<N - 1>()) / rho;
      }
    }
    return b;
  }

  const BlockSparseDelassus<N>& w_;
  const Eigen::VectorXd& q_;
  const Array<LocalLaw>& law_;
  const Array<double>& rho_;
  Index n_;
  double alpha_ = -1;
  Array<double> shift_, step_;
  Eigen::VectorXd centre_;
  Array<LocalSolver<N>> local_;
  Array<Block> factor_, constant_;
  Array<char> open_;
  BlockSparseLU<N> lu_;
  bool analysed_ = false;
};

}  // namespace jampack
