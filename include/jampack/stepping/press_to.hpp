// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/stepping/compaction.hpp>
#include <utility>

namespace jampack {

/// How a packing is brought to a small stress.
struct PressOptions {
  double stress = 1e-5;        ///< sigma0 wanted, > 0, in the unit of Young's modulus
  double accuracy = 0.1;       ///< |P - sigma0| / sigma0 reached, in (0, 1)
  double first_strain = 2e-3;  ///< largest volumetric strain of a step, > 0
  double inertia = 0.01;       ///< what a step's inertia may add to P, over sigma0
  Index max_steps = 400;       ///< where to give up
};

/// Presses a packing that carries less than sigma0 until its granular pressure is sigma0, homothetically, in
/// steps that start from the affine flow and are slow enough for inertia not to count; a step that overshoots
/// is taken back and halved. The last step holds the walls still. `progress(run)` is called after every step.
/// Throws InvalidInput for options outside their ranges, NotConverged when the stress is not reached.
template <class Packing, ContactLaw Law, class Solver, class Discretisation, class Progress>
void press_to(Compaction<Packing, Law, Solver, Discretisation>& run, const PressOptions& options,
              Progress&& progress) {
  constexpr int Dim = Packing::dimension;
  require(std::isfinite(options.stress) && options.stress > 0,
          "press_to: the stress must be positive and finite, got " + std::to_string(options.stress));
  require(options.accuracy > 0 && options.accuracy < 1 && options.first_strain > 0 && options.inertia > 0,
          "press_to: needs an accuracy in (0, 1), a positive first strain and a positive inertia");
  auto& packing = run.packing;
  auto& step = run.step;
  const double distance = run.mean_wall_distance();
  const double density = packing.model->material.density;

  // One step of this volumetric strain (0: none, the walls hold), from the affine flow that goes with it.
  const auto close = [&](double strain) {
    const double shrink = std::exp(-strain / Dim);
    const double length = packing.room.scale * distance;
    // rho (dL / h)^2 over the strain is the stress that stopping the whole flow in this step would take.
    const double slow = std::max(strain, 0.01 * options.first_strain);
    const double h = length * std::sqrt(density * slow / (options.inertia * options.stress)) / Dim;
    const bool converged = run.step_to(shrink * packing.room.scale, h, [&] {
      for (auto& grain : packing.grains) {
        const Vector<Dim> flow = (shrink - 1) / h * (grain.centre() - packing.room.centre);
        grain.velocity.colwise() = flow;
      }
      return FirstGuess::rest;
    });
    if (!converged) ++run.n_failed;
    return converged;
  };

  const double least = (1 - options.accuracy) * options.stress;
  const double most = (1 + options.accuracy) * options.stress;
  double strain = options.first_strain, pressure = std::max(0.0, run.pressure());
  for (Index n = 0; n < options.max_steps; ++n) {
    const auto saved = step.contacts;
    const double scale = packing.room.scale;

    const bool hold = pressure >= least;
    const bool converged = close(hold ? 0.0 : strain);
    const double reached = converged ? run.pressure() : 0.0;
    if (converged) progress(std::as_const(run));
    if (hold && converged && reached >= least && reached <= most) return;
    if (converged && reached <= most) {
      if (!hold) {
        // Twice the step, or what the last slope asks for less a tenth: P grows faster than its last slope.
        const double growth = reached - pressure;
        double next = std::min(2 * strain, options.first_strain);
        if (growth > 0) next = std::min(next, 0.9 * strain * (options.stress - reached) / growth);
        strain = std::max(next, 0.1 * strain);
      }
      pressure = std::max(0.0, reached);
      continue;
    }
    if (converged) {
      for (Index g = 0; g < packing.grains.size(); ++g) packing.grains[g].position = run.position_before[g];
      step.contacts = saved;
      packing.room.scale = scale;
    }
    strain *= reached > 4 * options.stress ? 0.25 : 0.5;
    if (strain < 1e-10)
      throw NotConverged("pressing to stress " +
                         std::to_string(options.stress / packing.model->material.young) +
                         " E: steps failed down to a strain of 1e-10 after " + std::to_string(run.n_steps) +
                         " steps, P over the stress wanted " + std::to_string(pressure / options.stress) +
                         ": " + (run.report.converged ? "every step overshoots" : run.report.reason) +
                         "; try another seed or more cells");
  }
  throw NotConverged("pressing to stress: P is " + std::to_string(pressure / options.stress) +
                     " of the stress wanted after " + std::to_string(options.max_steps) +
                     " steps; try another seed");
}

template <class Packing, ContactLaw Law, class Solver, class Discretisation>
void press_to(Compaction<Packing, Law, Solver, Discretisation>& run, const PressOptions& options) {
  press_to(run, options, [](const auto&) {});
}

}  // namespace jampack
