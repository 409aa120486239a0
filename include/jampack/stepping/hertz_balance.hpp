// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <jampack/detection/ball_gaps.hpp>
#include <jampack/detection/ball_warm_start.hpp>
#include <jampack/detection/r_tree.hpp>
#include <jampack/law/hertz_check.hpp>
#include <jampack/stepping/ball_law.hpp>
#include <string>

namespace jampack {

/// How far to balance.
struct HertzBalanceOptions {
  double tolerance = 1e-10;  ///< on max |sum F| of a ball over the largest contact force
  Index max_iterations = 500;
};

/// A state of balance and what it took.
template <int Dim>
struct HertzBalance {
  Array<BallForce<Dim>> forces;  ///< contacts with the force of the law at the present gaps
  double energy = 0.0;           ///< stored in the contacts
  double imbalance = 0.0;        ///< max |sum F| of a ball over the largest contact force; 0 without contact
  Index iterations = 0;
};

namespace detail {

/// One contact of two balls or a ball and a wall under HertzCheck: f = scale delta^exponent.
template <int Dim>
struct HertzSpring {
  double delta = 0.0, force = 0.0, stiffness = 0.0, energy = 0.0;

  HertzSpring(const HertzCheck& law, const Balls<Dim>& balls, const BallGap<Dim>& contact) {
    if (contact.gap >= 0) return;
    const double radius = 0.5 * balls.diameter[contact.candidate];
    double relative_radius = radius;
    if (!contact.at_wall()) {
      const double other = 0.5 * balls.diameter[contact.antagonist];
      relative_radius = radius * other / (radius + other);
    }
    constexpr double exponent = Dim == 3 ? 1.5 : 1.0;
    delta = -contact.gap;
    force = law.force<Dim>(contact.at_wall() ? law.modulus_at_wall() : law.modulus_of_two_grains(),
                           relative_radius, delta);
    stiffness = exponent * force / delta;
    energy = force * delta / (exponent + 1.0);
  }
};

}  // namespace detail

/// Moves the balls to a minimum of the energy of their HertzCheck contacts in a room at rest: the
/// quasi-static, frictionless small-strain model (docs/theory/rigid_stage.md, section 5). Newton's method on
/// the exact forces with a tangent kept positive definite (the contacts' stiffness along their normals; the
/// negative geometric part is left out), and a line search on the energy. Balls without contact stay where
/// they are. Throws InvalidInput for unusable input, NotConverged when the tolerance is not reached.
template <int Dim>
HertzBalance<Dim> balance(Balls<Dim>& balls, const Container<Dim>& room, const HertzCheck& law,
                          const HertzBalanceOptions& options = {}) {
  require_usable(balls);
  require_usable_law(law);
  const Index n = balls.size();
  RTree<Dim> broad_phase;
  Array<BallGap<Dim>> gaps;
  HertzBalance<Dim> result;
  Eigen::VectorXd force(Dim * n);
  double largest = 0.0;
  const auto evaluate = [&] {
    find_gaps(broad_phase, balls, room, 0.0, gaps);
    force.setZero();
    largest = 0.0;
    double energy = 0.0;
    for (const auto& contact : gaps) {
      const detail::HertzSpring<Dim> spring(law, balls, contact);
      energy += spring.energy;
      largest = std::max(largest, spring.force);
      force.template segment<Dim>(Dim * contact.candidate) += spring.force * contact.normal;
      if (!contact.at_wall())
        force.template segment<Dim>(Dim * contact.antagonist) -= spring.force * contact.normal;
    }
    return energy;
  };
  const auto imbalance = [&] {
    double most = 0.0;
    for (Index i = 0; i < n; ++i) most = std::max(most, force.template segment<Dim>(Dim * i).norm());
    return largest > 0 ? most / largest : 0.0;
  };

  result.energy = evaluate();
  result.imbalance = imbalance();
  Eigen::SparseMatrix<double> tangent(Dim * n, Dim * n);
  double damping = 1e-8;
  while (result.imbalance > options.tolerance) {
    if (result.iterations++ >= options.max_iterations) {
      char text[200];
      std::snprintf(
          text, sizeof text,
          "Hertz balance: imbalance %.3g of %.3g after %td iterations; try smaller compression steps "
          "or a looser tolerance",
          result.imbalance, options.tolerance, options.max_iterations);
      throw NotConverged(text);
    }
    std::vector<Eigen::Triplet<double>> entries;
    double stiffest = 0.0;
    const auto add = [&](Index a, Index b, const Matrix<Dim>& block) {
      for (Index i = 0; i < Dim; ++i)
        for (Index j = 0; j < Dim; ++j)
          entries.emplace_back(static_cast<int>(Dim * a + i), static_cast<int>(Dim * b + j), block(i, j));
    };
    for (const auto& contact : gaps) {
      const detail::HertzSpring<Dim> spring(law, balls, contact);
      stiffest = std::max(stiffest, spring.stiffness);
      const Matrix<Dim> block = spring.stiffness * contact.normal * contact.normal.transpose();
      add(contact.candidate, contact.candidate, block);
      if (contact.at_wall()) continue;
      add(contact.antagonist, contact.antagonist, block);
      add(contact.candidate, contact.antagonist, -block);
      add(contact.antagonist, contact.candidate, -block);
    }
    for (Index i = 0; i < n; ++i) add(i, i, damping * stiffest * Matrix<Dim>::Identity());
    tangent.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(tangent);
    Eigen::VectorXd move = solver.solve(force);

    // Soft modes may point far: no ball moves by more than a tenth of its radius at once.
    double factor = 1.0;
    for (Index i = 0; i < n; ++i)
      factor = std::min(
          factor, 0.05 * balls.diameter[i] / std::max(move.template segment<Dim>(Dim * i).norm(), 1e-300));
    const Array<Vector<Dim>> start = balls.position;
    const double slope = force.dot(move), start_energy = result.energy, start_imbalance = result.imbalance;
    bool better = false;
    for (int cut = 0; cut < 30 && !better; ++cut, factor *= 0.5) {
      for (Index i = 0; i < n; ++i)
        balls.position[i] = start[i] + factor * move.template segment<Dim>(Dim * i);
      result.energy = evaluate();
      result.imbalance = imbalance();
      // Near the minimum the energy is flat to rounding; then the forces decide.
      better = result.energy <= start_energy - 1e-4 * factor * slope ||
               (result.energy <= start_energy * (1 + 1e-13) && result.imbalance < start_imbalance);
    }
    if (!better) {
      balls.position = start;
      result.energy = evaluate();
      result.imbalance = imbalance();
    }
    damping = better ? std::max(1e-10, 0.3 * damping) : std::min(1.0, 100.0 * damping);
  }
  for (const auto& contact : gaps) {
    const detail::HertzSpring<Dim> spring(law, balls, contact);
    if (spring.force > 0) result.forces.push_back({contact, spring.force * contact.normal});
  }
  return result;
}

}  // namespace jampack
