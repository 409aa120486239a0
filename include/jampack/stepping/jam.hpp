// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <jampack/analysis/ball_network.hpp>
#include <jampack/analysis/coordination.hpp>
#include <jampack/body/rigid_balls.hpp>
#include <jampack/body/rigid_walls.hpp>
#include <jampack/packing/random_packing.hpp>
#include <jampack/solver/default_solver.hpp>
#include <jampack/solver/gauss_seidel.hpp>
#include <jampack/stepping/moreau_rigid.hpp>
#include <limits>
#include <string>
#include <utility>

namespace jampack {

/// How to jam. Times are in the unit T = <d> sqrt(density / stress), the time in which the stress moves a
/// grain by its own size, so that nothing here depends on the units of the scene.
struct JamOptions {
  double stress = 1.0;   ///< sigma0 on every wall, > 0, force / length^(Dim - 1)
  double density = 1.0;  ///< rho of the grains, > 0, mass / length^Dim

  // Jammed (docs/theory/rigid_stage.md, section 4):
  double fraction_change = 1e-4;  ///< largest relative change of phi over a time T
  double kinetic_energy = 1e-6;   ///< largest kinetic energy over sigma0 V, walls included
  double grain_imbalance = 1e-2;  ///< largest |sum F| / sum |F| of a grain that is held
  double tolerance = 1e-5;        ///< on scaled_residual; tightened where the balance of grains asks for it

  // The way there:
  double max_step = 0.1;           ///< in T; halved, and grown again, where grains would move too far at once
  double flow_tolerance = 1e-4;    ///< on scaled_residual while grains still flow
  double drag_time = 2.0;          ///< in T; the drag that brings rattlers to rest
  double max_displacement = 0.05;  ///< of a grain or wall in a step, in <d>
  double max_time = 300.0;         ///< in T; where to give up
};

/// What the jamming took, and how good the end state is.
struct JamReport {
  Index steps = 0;
  Index refused_steps = 0;
  Index sweeps = 0;
  double time = 0.0;             ///< simulated, in T
  double seconds = 0.0;          ///< wall time
  double scaled_residual = 0.0;  ///< of the last contact problem
  double kinetic_energy = 0.0;   ///< over sigma0 V
  double grain_imbalance = 0.0;  ///< max |sum F| / sum |F| over grains
  double max_penetration = 0.0;  ///< over <d>
};

/// A jammed packing of rigid balls: what the deformable stage takes over.
template <int Dim>
struct JammedPacking {
  Packing<Dim> packing;
  ContactNetwork<Dim> network;  ///< contacts and the forces they carry
  Array<char> is_rattler;       ///< 1 for balls that nothing holds
  Coordination coordination;
  double stress = 0.0;            ///< sigma0 it carries
  double packing_fraction = 0.0;  ///< phi0 of the true balls
  JamReport report;
};

namespace detail {

inline std::string scientific(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

// phi at the times of the steps, for its change over the last unit of time.
class FractionHistory {
 public:
  void add(double time, double fraction) {
    time_.push_back(time);
    fraction_.push_back(fraction);
    while (next_after_ < time_.size() && time_[next_after_] <= time - 1.0) ++next_after_;
  }
  /// Relative change over the last unit of time or a little more; infinite before there was one.
  double change() const {
    if (next_after_ == 0) return std::numeric_limits<double>::infinity();
    const auto [low, high] = std::minmax_element(fraction_.begin() + next_after_ - 1, fraction_.end());
    return (*high - *low) / fraction_.back();
  }

 private:
  Array<double> time_, fraction_;
  Index next_after_ = 0;
};

inline void require_usable(const JamOptions& options) {
  const auto positive = [](double value, const char* name) {
    require(std::isfinite(value) && value > 0,
            "jamming: " + std::string(name) + " must be positive and finite, got " + std::to_string(value));
  };
  positive(options.stress, "the stress");
  positive(options.density, "the density");
  positive(options.fraction_change, "the change of packing fraction");
  positive(options.kinetic_energy, "the kinetic energy");
  positive(options.grain_imbalance, "the grain imbalance");
  positive(options.tolerance, "the tolerance");
  positive(options.max_step, "the largest step");
  positive(options.flow_tolerance, "the tolerance in flow");
  positive(options.max_displacement, "the largest displacement");
  positive(options.max_time, "the time limit");
}

}  // namespace detail

/// Jams a loose packing: the walls close under a constant stress, all by the same strain and without
/// friction, until phi changes by less than `fraction_change` over a time T, the kinetic energy is below
/// `kinetic_energy` sigma0 V, the contact problem is solved to `tolerance` and every grain that is held is in
/// balance to `grain_imbalance`. The law acts between grains:
/// Signorini (one unknown a contact) or SignoriniCoulomb. Deterministic. `progress(const JamReport&, phi)` is
/// called after every step.
/// Throws InvalidInput for impossible input and NotConverged when the time limit passes first.
template <int Dim, ContactLaw Law, class Solver, class Progress>
JammedPacking<Dim> jam(const Packing<Dim>& loose, const Law& law, const JamOptions& options, Solver solver,
                       Progress&& progress) {
  detail::require_usable(options);
  require_usable(loose.box);
  const Stopwatch clock;
  const double unit_time = loose.balls.mean_diameter() * std::sqrt(options.density / options.stress);
  const double solid = loose.balls.volume();
  RigidBalls<Dim> bodies = rigid_balls(loose.balls, options.density);
  RigidWalls<Dim> walls{container(loose.box)};
  MoreauRigid<Dim, Law> stepping(
      law, {.max_displacement = options.max_displacement, .drag_time = options.drag_time * unit_time});
  const double mass = bodies.total_mass();

  JamReport report;
  detail::FractionHistory history;
  const Index least_contacts = contacts_to_hold<Dim>(friction_between_balls(law) > 0);
  double tolerance = options.tolerance;
  double step = 0.1 * options.max_step;
  double energy = 1.0;
  Index n_slow = 0;
  while (true) {
    drive_by_stress(walls, options.stress, mass);
    // While grains flow a rough solution moves them as well, and some sweeps give that at once. Near rest the
    // errors of the forces would keep the grains moving: more sweeps the longer it takes, and at rest the
    // solver itself.
    const bool slow = energy <= std::max(1e-5, 10.0 * options.kinetic_energy) ||
                      history.change() <= std::max(1e-3, 10.0 * options.fraction_change);
    const bool at_rest = energy <= options.kinetic_energy && history.change() <= options.fraction_change;
    n_slow = slow ? n_slow + 1 : 0;
    solver.stop.tolerance = tolerance;
    const GaussSeidel sweeps{{slow ? tolerance : std::max(tolerance, options.flow_tolerance),
                              std::min<Index>(1000 + 100 * n_slow, 5000)}};
    const RigidStepReport done = at_rest ? stepping.step(bodies, walls, step * unit_time, solver)
                                         : stepping.step(bodies, walls, step * unit_time, sweeps);
    report.sweeps += done.solve.sweeps;
    if (!done.accepted) {
      ++report.refused_steps;
      step *= 0.5;
      if (step < 1e-9 * options.max_step)
        throw NotConverged("jamming: grains move further than " +
                           detail::scientific(options.max_displacement) + " <d> in any step, at step " +
                           std::to_string(report.steps) +
                           "; start from balls that do not overlap each other or the walls");
      continue;
    }
    ++report.steps;
    report.time += step;
    const double volume = walls.room.volume();
    energy = (bodies.kinetic_energy() + walls.kinetic_energy()) / (options.stress * volume);
    report.kinetic_energy = energy;
    report.scaled_residual = done.solve.residual;
    report.seconds = clock.seconds();
    report.max_penetration = 0.0;
    for (const auto& entry : stepping.forces())
      report.max_penetration =
          std::max(report.max_penetration, -entry.contact.gap / bodies.balls.mean_diameter());
    history.add(report.time, solid / volume);
    progress(report, solid / volume);

    if (at_rest && done.solve.converged && energy <= options.kinetic_energy &&
        history.change() <= options.fraction_change) {
      const auto network = contact_network(bodies.balls, volume, stepping.forces());
      const auto rattlers = find_rattlers(network, least_contacts, contact_threshold(network));
      report.grain_imbalance = grain_imbalance(network, rattlers);
      const bool any_held = std::count(rattlers.begin(), rattlers.end(), 0) > 0;
      if (any_held && report.grain_imbalance <= options.grain_imbalance) break;
      // What is left may be the solver's error: forces to be balanced better need a better solution.
      tolerance = std::max(0.9 * tolerance, 1e-3 * options.tolerance);
    }
    if (report.time > options.max_time)
      throw NotConverged("jamming: not at rest after " + std::to_string(report.steps) + " steps (time " +
                         detail::scientific(report.time) + " <d> sqrt(density/stress)): kinetic energy " +
                         detail::scientific(energy) + " of " + detail::scientific(options.kinetic_energy) +
                         " sigma0 V, relative change of phi " + detail::scientific(history.change()) +
                         " of " + detail::scientific(options.fraction_change) + ", scaled residual " +
                         detail::scientific(done.solve.residual) + " of " + detail::scientific(tolerance) +
                         ", grain imbalance " + detail::scientific(report.grain_imbalance) + " of " +
                         detail::scientific(options.grain_imbalance) +
                         "; try another seed, a smaller max_step or a looser tolerance");
    step = std::min(options.max_step, 1.2 * step);
  }

  JammedPacking<Dim> jammed;
  jammed.packing.balls = bodies.balls;
  jammed.packing.box = loose.box;
  jammed.packing.box.lower = walls.room.centre + walls.room.scale * (loose.box.lower - walls.room.centre);
  jammed.packing.box.upper = walls.room.centre + walls.room.scale * (loose.box.upper - walls.room.centre);
  jammed.stress = options.stress;
  jammed.packing_fraction = solid / walls.room.volume();
  jammed.network = contact_network(jammed.packing.balls, walls.room.volume(), stepping.forces());
  jammed.coordination = coordination(jammed.network, least_contacts);
  jammed.is_rattler = find_rattlers(jammed.network, least_contacts, jammed.coordination.threshold);
  report.seconds = clock.seconds();
  jammed.report = report;
  return jammed;
}

template <int Dim, ContactLaw Law>
JammedPacking<Dim> jam(const Packing<Dim>& loose, const Law& law, const JamOptions& options = {}) {
  return jam(loose, law, options, DefaultSolver{.patience = 2000}, [](const JamReport&, double) {});
}

}  // namespace jampack
