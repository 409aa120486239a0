// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <jampack/problem/stored_blocks.hpp>
#include <jampack/solver/block_sparse_lu.hpp>
#include <jampack/solver/contact_solver.hpp>

namespace jampack {

/// Alternating direction method of multipliers with the contacts' own scaling: W x + q + s + m = 0 for free
/// reactions x, which a penalty beta D and the multiplier m tie to their copies z in the cones; the de Saxcé
/// term s is taken from the last velocity, and beta follows the balance of primal and dual residual
/// (Acary, Brémond, Huber: On solving contact problems with Coulomb friction, 2018, section 5).
struct Admm {
  StoppingCriterion stop{.max_sweeps = 20000};
  double penalty = 1;       ///< first beta, relative to D = diag(1/rho), > 0
  double relaxation = 1.6;  ///< in (0, 2)

  template <class Problem>
  SolveReport solve(const Problem& problem, Eigen::VectorXd& r) const {
    constexpr int N = Problem::n_unknowns;
    static_assert(!Problem::LocalLaw::is_compliant, "ADMM solves rigid contact laws");
    using Block = Eigen::Matrix<double, N, N>;
    require(penalty > 0 && relaxation > 0 && relaxation < 2, "ADMM: penalty > 0 and relaxation in (0, 2)");
    BestIterate<Problem> iterate(problem, stop, r);
    const Index n = problem.n_contacts();
    Index iterations = 0;
    if (!iterate.converged() && n > 0) {
      const BlockSparseDelassus<N>& w = as_block_sparse(problem.delassus);
      const Array<double>& rho = iterate.rho();
      BlockSparseLU<N> lu;
      lu.analyse(symmetric_pattern(w));
      double beta = penalty;
      const auto factorise = [&] {
        return lu.factorise([&](Index c, auto add) {
          w.for_each_block(c, [&](Index d, const Block& block) { add(d, block); });
          add(c, Block(beta / rho[c] * Block::Identity()));
        });
      };
      bool usable = factorise();
      Eigen::VectorXd z = r, x = r,
                      multiplier = -iterate.velocity() - de_saxce_shift(problem, iterate.velocity());
      Eigen::VectorXd old_z, shift;
      for (; usable && iterations < stop.max_sweeps && !iterate.converged();) {
        ++iterations;
        // Velocity is -multiplier - shift at the fixed point: W x + q + shift + multiplier = 0.
        shift = de_saxce_shift(problem, iterate.velocity());
        x = -problem.free_velocity - shift - multiplier;
        for (Index c = 0; c < n; ++c)
          x.template segment<N>(N * c) += beta / rho[c] * z.template segment<N>(N * c);
        lu.solve(x);
        old_z = z;
        double primal = 0, dual = 0;
        for (Index c = 0; c < n; ++c) {
          const double weight = beta / rho[c];
          const ContactVector<N> relaxed =
              relaxation * x.template segment<N>(N * c) + (1 - relaxation) * old_z.template segment<N>(N * c);
          const ContactVector<N> free = relaxed + multiplier.template segment<N>(N * c) / weight;
          const ContactVector<N> next = project_on_friction_cone<N>(free, problem.law[c].friction);
          multiplier.template segment<N>(N * c) = weight * (free - next);
          z.template segment<N>(N * c) = next;
          primal += (x.template segment<N>(N * c) - next).squaredNorm();
          dual += beta * beta * (next - old_z.template segment<N>(N * c)).squaredNorm();
        }
        iterate.judge(z);
        if (iterations % 20 == 0) {
          if (iterate.out_of_time()) break;
          const double ratio = std::sqrt(primal / std::max(dual, 1e-300));
          if (ratio > 5 || ratio < 0.2) {
            beta = std::clamp(beta * std::clamp(std::sqrt(ratio), 0.2, 5.0), 1e-6, 1e6);
            usable = factorise();
          }
        }
      }
      r = iterate.best();
    }
    return iterate.report(iterations);
  }

 private:
  template <class Problem>
  static Eigen::VectorXd de_saxce_shift(const Problem& problem, const Eigen::VectorXd& u) {
    constexpr int N = Problem::n_unknowns;
    Eigen::VectorXd shift = Eigen::VectorXd::Zero(u.size());
    if constexpr (N > 1)
      for (Index c = 0; c < problem.n_contacts(); ++c)
        shift[N * c] = problem.law[c].friction * u.template segment<N - 1>(N * c + 1).norm();
    return shift;
  }
};

}  // namespace jampack
