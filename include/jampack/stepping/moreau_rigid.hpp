// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <jampack/body/rigid_balls.hpp>
#include <jampack/body/rigid_walls.hpp>
#include <jampack/detection/ball_gaps.hpp>
#include <jampack/detection/ball_warm_start.hpp>
#include <jampack/detection/r_tree.hpp>
#include <jampack/geometry/frame.hpp>
#include <jampack/problem/contact_problem.hpp>
#include <jampack/problem/rigid_balls_delassus.hpp>
#include <jampack/solver/contact_solver.hpp>
#include <jampack/stepping/ball_law.hpp>
#include <limits>
#include <string>
#include <utility>

namespace jampack {

/// Parameters of the Moreau-Jean step of rigid balls.
struct MoreauRigidOptions {
  double theta = 1.0;  ///< in [1/2, 1]
  double max_displacement =
      0.1;                     ///< a step that moves a ball or wall further is refused; mean diameters, > 0
  double wall_friction = 0.0;  ///< Coulomb's coefficient at walls, >= 0; for laws with friction only
  /// Time in which a drag of the surroundings slows free flight and free spin by a factor e, > 0; none by
  /// default. It brings rattlers to rest, which nothing else does.
  double drag_time = std::numeric_limits<double>::infinity();
};

/// What one step did.
struct RigidStepReport {
  bool accepted = false;          ///< false: nothing was changed, take a smaller step
  double max_displacement = 0.0;  ///< of a ball or wall over the step, length
  SolveReport solve;
};

/// Moreau-Jean theta stepping of rigid balls between plane walls, contact inelastic (M. Jean, "The non-smooth
/// contact dynamics method", CMAME 177, 1999; docs/theory/rigid_stage.md, eq. 1 to 4):
///   contacts are found at q~ = q + h (1 - theta) v,
///   M (v+ - D v) = h f + H^T r,  and the law holds between r and u+ + g~ n / (theta h), u+ = H v+,
///   q+ = q~ + h theta v+.
/// with D = 1, or exp(- h / drag_time). The gap itself stands in the condition, not its rate alone, so
/// penetration does not add up. The law is compiled in: under a law without friction a contact carries one
/// unknown and turns no ball.
template <int Dim, ContactLaw Law = SignoriniCoulomb, BroadPhase<Dim> Broad = RTree<Dim>>
class MoreauRigid {
  static constexpr int N = n_contact_unknowns<Law, Dim>;
  using Delassus = RigidBallsDelassus<Dim, N>;

 public:
  using Problem = ContactProblem<Delassus, Law>;

  /// Throws InvalidInput for parameters outside their ranges.
  explicit MoreauRigid(Law law, MoreauRigidOptions options = {}, Broad broad_phase = Broad())
      : law_(law), options_(options), broad_phase_(std::move(broad_phase)) {
    require_usable_law(law);
    require(options.theta >= 0.5 && options.theta <= 1.0,
            "Moreau stepping: theta must be in [1/2, 1], got " + std::to_string(options.theta));
    require(std::isfinite(options.max_displacement) && options.max_displacement > 0,
            "Moreau stepping: the largest displacement must be positive, got " +
                std::to_string(options.max_displacement));
    require(std::isfinite(options.wall_friction) && options.wall_friction >= 0,
            "Moreau stepping: wall friction must be finite and not negative, got " +
                std::to_string(options.wall_friction));
    require(options.drag_time > 0,
            "Moreau stepping: the drag time must be positive, got " + std::to_string(options.drag_time));
  }

  /// One step of length h > 0 (time). The solver's report is handed on, converged or not: what to do about a
  /// poor solution is the caller's to decide. The scene must not change its number of balls between steps.
  template <ContactSolver<Problem> Solver>
  RigidStepReport step(RigidBalls<Dim>& bodies, RigidWalls<Dim>& walls, double h, const Solver& solver) {
    require(std::isfinite(h) && h > 0,
            "Moreau stepping: the step must be positive, got " + std::to_string(h));
    for (Index i = 0; i < bodies.size(); ++i)
      require(bodies.velocity[i].allFinite() && bodies.spin[i].allFinite() && bodies.force[i].allFinite(),
              "Moreau stepping: velocity, spin or force of ball " + std::to_string(i) + " is not finite");
    const double theta = options_.theta;
    double limit = displacement_limit(bodies, walls, h);

    Balls<Dim> mid = bodies.balls;
    Container<Dim> mid_room = walls.room;
    for (Index i = 0; i < mid.size(); ++i) mid.position[i] += h * (1.0 - theta) * bodies.velocity[i];
    mid_room.scale += h * (1.0 - theta) * walls.scale_rate;
    // Two balls that each move by the limit are caught.
    find_gaps(broad_phase_, mid, mid_room, 2.0 * limit, gaps_);
    double deepest = 0.0;
    for (const auto& gap : gaps_) deepest = std::max(deepest, -gap.gap);
    if (2.0 * deepest > limit) {  // what overlaps will be pushed out
      limit = std::min(2.0 * deepest, options_.max_displacement * bodies.balls.mean_diameter());
      find_gaps(broad_phase_, mid, mid_room, 2.0 * limit, gaps_);
    }

    const Problem problem = contact_problem(bodies, walls, mid, h);
    Eigen::VectorXd reaction = first_guess(problem, h);
    RigidStepReport report;
    report.solve = solver.solve(problem, reaction);

    // v+ = v_free + M^-1 H^T r
    const auto change = problem.delassus.motion(reaction);
    const double slowed = std::exp(-h / options_.drag_time);
    Array<Vector<Dim>> velocity(bodies.size(), Vector<Dim>::Zero());
    for (Index i = 0; i < bodies.size(); ++i) {
      velocity[i] =
          slowed * bodies.velocity[i] + h / bodies.mass[i] * bodies.force[i] + change.body[i].velocity;
      report.max_displacement = std::max(
          report.max_displacement, h * (theta * velocity[i] + (1.0 - theta) * bodies.velocity[i]).norm());
    }
    const double rate = walls.scale_rate + h * walls.inverse_mass * walls.force + change.mode;
    for (const double distance : walls.room.distance)
      report.max_displacement =
          std::max(report.max_displacement,
                   std::abs(h * distance * (theta * rate + (1.0 - theta) * walls.scale_rate)));
    report.accepted = report.max_displacement <= limit;
    if (!report.accepted) return report;

    for (Index i = 0; i < bodies.size(); ++i) {
      Spin<Dim> mean_spin = (1.0 - theta) * bodies.spin[i];
      bodies.spin[i] *= slowed;
      if constexpr (N > 1) bodies.spin[i] += change.body[i].spin;
      mean_spin += theta * bodies.spin[i];
      mid.position[i] += h * theta * velocity[i];
      if (!mean_spin.isZero(0.0)) mid.orientation[i] = turned<Dim>(mid.orientation[i], h * mean_spin);
    }
    bodies.velocity = std::move(velocity);
    bodies.balls = std::move(mid);
    walls.room.scale = mid_room.scale + h * theta * rate;
    walls.scale_rate = rate;

    forces_.resize(gaps_.size());
    for (Index c = 0; c < gaps_.size(); ++c) {
      const auto& frame = problem.delassus.contacts()[c].frame;
      forces_[c] = {gaps_[c],
                    frame.template topRows<N>().transpose() * reaction.template segment<N>(N * c) / h};
    }
    warm_start_.remember(forces_);
    return report;
  }

  /// Contacts of the last accepted step, with the force (mean over the step) each carried, and those near by
  /// with none. Gaps and normals are those the step used.
  const Array<BallForce<Dim>>& forces() const { return forces_; }

 private:
  // How far a body may move in this step: three times what it would do freely, so that few gaps need to be
  // looked at where everything is nearly at rest, and never beyond the limit of the options.
  double displacement_limit(const RigidBalls<Dim>& bodies, const RigidWalls<Dim>& walls, double h) const {
    double fastest = 0.0;
    for (Index i = 0; i < bodies.size(); ++i)
      fastest = std::max({fastest, bodies.velocity[i].norm(),
                          (bodies.velocity[i] + h / bodies.mass[i] * bodies.force[i]).norm()});
    const double rate = std::max(std::abs(walls.scale_rate),
                                 std::abs(walls.scale_rate + h * walls.inverse_mass * walls.force));
    for (const double distance : walls.room.distance) fastest = std::max(fastest, rate * distance);
    const double most = options_.max_displacement * bodies.balls.mean_diameter();
    return std::clamp(3.0 * h * fastest, 0.1 * most, most);
  }

  // W, q and the laws of the step: q = H v_free + g~ n / (theta h), the walls' mode being a body of W.
  Problem contact_problem(const RigidBalls<Dim>& bodies, const RigidWalls<Dim>& walls, const Balls<Dim>& mid,
                          double h) const {
    Array<InverseInertia> inertia(bodies.size());
    for (Index i = 0; i < bodies.size(); ++i) inertia[i] = {1.0 / bodies.mass[i], 1.0 / bodies.inertia[i]};
    Array<BallContact<Dim>> contacts;
    Array<typename Law::Contact> laws;
    contacts.reserve(gaps_.size());
    laws.reserve(gaps_.size());
    for (const BallGap<Dim>& gap : gaps_) {
      contacts.push_back({.candidate = gap.candidate,
                          .antagonist = gap.antagonist,
                          .frame = contact_frame<Dim>(gap.normal),
                          .candidate_arm = 0.5 * mid.diameter[gap.candidate],
                          .antagonist_arm = gap.at_wall() ? 0.0 : 0.5 * mid.diameter[gap.antagonist],
                          .wall_rate = gap.at_wall() ? -walls.room.distance[gap.wall] : 0.0});
      laws.push_back(ball_law<Dim>(law_, mid, gap, h, options_.theta, options_.wall_friction));
    }
    Delassus delassus(std::move(inertia), std::move(contacts), walls.inverse_mass);

    const Eigen::VectorXd nothing = Eigen::VectorXd::Zero(N * gaps_.size());
    auto free = delassus.motion(nothing);
    const double slowed = std::exp(-h / options_.drag_time);
    for (Index i = 0; i < bodies.size(); ++i) {
      free.body[i].velocity = slowed * bodies.velocity[i] + h / bodies.mass[i] * bodies.force[i];
      if constexpr (N > 1) free.body[i].spin = slowed * bodies.spin[i];
    }
    free.mode = walls.scale_rate + h * walls.inverse_mass * walls.force;
    Eigen::VectorXd free_velocity(nothing.size());
    for (Index c = 0; c < gaps_.size(); ++c) {
      ContactVector<N> u = delassus.velocity(free, nothing, c);
      u[0] += gaps_[c].gap / (options_.theta * h);
      free_velocity.template segment<N>(N * c) = u;
    }
    return Problem(std::move(delassus), std::move(free_velocity), std::move(laws));
  }

  Eigen::VectorXd first_guess(const Problem& problem, double h) const {
    Eigen::VectorXd reaction(N * gaps_.size());
    for (Index c = 0; c < gaps_.size(); ++c)
      reaction.template segment<N>(N * c) =
          problem.delassus.contacts()[c].frame.template topRows<N>() * (h * warm_start_.force(gaps_[c]));
    return reaction;
  }

  Law law_;
  MoreauRigidOptions options_;
  Broad broad_phase_;
  BallWarmStart<Dim> warm_start_;
  Array<BallGap<Dim>> gaps_;
  Array<BallForce<Dim>> forces_;
};

}  // namespace jampack
