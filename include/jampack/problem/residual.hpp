// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <jampack/problem/contact_problem.hpp>

namespace jampack {

/// u = W r + q, recomputed from nothing but the problem and r.
template <class Problem>
void contact_velocity(const Problem& problem, const Eigen::VectorXd& r, Eigen::VectorXd& u) {
  problem.delassus.apply(r, u);
  u += problem.free_velocity;
}

/// The step of the natural map at each contact: rho_c = N / tr W_cc, and for a block of trace zero
/// n / tr W (docs/theory/contact_solvers.md, eq. 5); or the problem's own. With it the residual has no units.
/// Throws InvalidInput where the problem's own are not one a contact.
template <class Problem>
Array<double> natural_map_steps(const Problem& problem) {
  if (!problem.step.empty()) {
    require(problem.step.size() == problem.n_contacts(),
            "contact problem: " + std::to_string(problem.step.size()) + " steps of the natural map for " +
                std::to_string(problem.n_contacts()) + " contacts");
    return problem.step;
  }
  constexpr int n = Problem::n_unknowns;
  Array<double> rho(problem.n_contacts());
  double total = 0;
  for (Index c = 0; c < rho.size(); ++c) {
    rho[c] = block_trace<n>(problem.delassus.diagonal_block(c));
    total += rho[c];
  }
  const double fallback = total > 0 ? static_cast<double>(n * rho.size()) / total : 1.0;
  for (double& x : rho) x = x > 0 ? n / x : fallback;
  return rho;
}

/// Natural map of one contact, r - P_K(r - rho (u + (friction |u_T| + c(r_N), 0, 0))): zero if and only if
/// r and u satisfy the law (docs/theory/contact_solvers.md, eq. 4).
template <int N, LocalContactLaw LocalLaw>
ContactVector<N> natural_map(const LocalLaw& law, const ContactVector<N>& r, const ContactVector<N>& u,
                             double rho) {
  ContactVector<N> velocity = de_saxce_velocity<N>(u, law.friction);
  if constexpr (LocalLaw::is_compliant) velocity[0] += law.compliance(r[0]);
  ContactVector<N> z;
  for (int i = 0; i < N; ++i) z[i] = r[i] - rho * velocity[i];
  return r - project_on_friction_cone<N>(z, law.friction);
}

/// scaled_residual from reactions and velocities u = W r + q at hand: root of the sum of squares of the
/// natural map with the steps rho, over max(|r|, |rho q|); over |r| alone (unless r = 0) where `of_reactions`
/// asks for that, a stricter measure where loads nearly cancel, or the steps are the problem's own. Zero for
/// an empty problem; NaN stays NaN.
template <class Problem>
double scaled_residual(const Problem& problem, const Array<double>& rho, const Eigen::VectorXd& r,
                       const Eigen::VectorXd& u, bool of_reactions = false) {
  constexpr int n = Problem::n_unknowns;
  double error = 0, reactions = 0, loads = 0;
  for (Index c = 0; c < problem.n_contacts(); ++c) {
    const ContactVector<n> rc = r.template segment<n>(n * c), uc = u.template segment<n>(n * c);
    error += natural_map<n>(problem.law[c], rc, uc, rho[c]).squaredNorm();
    reactions += rc.squaredNorm();
    loads += rho[c] * rho[c] * problem.free_velocity.template segment<n>(n * c).squaredNorm();
  }
  const bool by_reactions = (of_reactions || !problem.step.empty()) && reactions > 0;
  const double scale = by_reactions ? reactions : std::max(reactions, loads);
  return scale > 0 ? std::sqrt(error / scale) : std::sqrt(error);
}

/// The residual every solver stops on, free of units, recomputed from W r + q.
template <class Problem>
double scaled_residual(const Problem& problem, const Eigen::VectorXd& r) {
  Eigen::VectorXd u(r.size());
  contact_velocity(problem, r, u);
  return scaled_residual(problem, natural_map_steps(problem), r, u);
}

/// The residual of the literature (Siconos 4.4) from reactions and velocities u = W r + q at hand: the
/// natural map with rho = 1, over max(|q|, |r|, |u|). It mixes units; for comparison only.
template <class Problem>
double residual(const Problem& problem, const Eigen::VectorXd& r, const Eigen::VectorXd& u) {
  constexpr int n = Problem::n_unknowns;
  double error = 0;
  for (Index c = 0; c < problem.n_contacts(); ++c)
    error += natural_map<n>(problem.law[c], ContactVector<n>(r.template segment<n>(n * c)),
                            ContactVector<n>(u.template segment<n>(n * c)), 1.0)
                 .squaredNorm();
  const double scale = std::max({problem.free_velocity.norm(), r.norm(), u.norm()});
  return scale > 0 ? std::sqrt(error) / scale : std::sqrt(error);
}

template <class Problem>
double residual(const Problem& problem, const Eigen::VectorXd& r) {
  Eigen::VectorXd u(r.size());
  contact_velocity(problem, r, u);
  return residual(problem, r, u);
}

}  // namespace jampack
