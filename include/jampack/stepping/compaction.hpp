// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/analysis/granular_stress.hpp>
#include <jampack/analysis/soft_network.hpp>
#include <jampack/body/surface_measure.hpp>
#include <jampack/stepping/soft_step.hpp>

namespace jampack {

/// How fast and in which steps a packing is pressed.
struct CompactionOptions {
  double inertial_number = 1e-3;  ///< I = v0 sqrt(rho / E) with v0 the speed of each wall
  double kinetic_ratio = 1e-5;   ///< bound on rho v0^2 / P: over a strain step it is the imbalance of a grain
  double least_pressure = 1e-2;  ///< P / E that the bound reckons with where there is less
  double first_strain = 1e-3;    ///< first volumetric strain step, -d ln V
  double max_strain = 0.01;      ///< largest step
  double min_strain = 1e-7;      ///< below this the compaction is given up
  int easy_iterations = 30;      ///< a step that needed no more may be followed by a larger one
};

/// Presses a packing by homothetic closing of its room at constant wall speed, in adaptive implicit steps:
/// a step that fails is cut, one that was easy lets the next grow.
template <class Packing, ContactLaw Law, class Solver = ProximalNewton>
class Compaction {
 public:
  static constexpr int Dim = Packing::dimension;

  Packing packing;
  SoftStep<Packing, Law, Solver> step;
  CompactionOptions options;

  Index n_steps = 0;
  Index n_iterations = 0;
  Index n_linear_iterations = 0;
  Index n_failed = 0;
  double strain = 0;         ///< size of the next step
  double last_duration = 0;  ///< h of the last accepted step
  double last_pressure = 0;  ///< after it, >= 0; with `strain` and `last_duration` what a resumed run needs
  SoftStepReport report;     ///< of the last accepted step
  /// Of each grain at the start of the last accepted step; empty before the first. For the audit.
  Array<typename Packing::Nodal> position_before, velocity_before;

  Compaction(Packing start, Law law, CompactionOptions compaction = {}, SoftStepOptions step_options = {})
      : packing(std::move(start)),
        step(law, step_options),
        options(compaction),
        strain(compaction.first_strain) {}

  /// Volume of the grains (area in 2D), within their curved surfaces.
  double solid_volume() const {
    double sum = 0;
    for (const auto& grain : packing.grains)
      sum += measure_surface<Dim>(packing.model->boundary, grain.position).volume;
    return sum;
  }
  double packing_fraction() const { return solid_volume() / packing.room.volume(); }
  ContactNetwork<Dim> network() const {
    return contact_network<Packing, Dim>(packing, step.pairs, step.walls);
  }
  double pressure() const { return granular_pressure(network()); }

  /// One accepted step of at most `largest` volumetric strain. Throws NotConverged, the packing being as
  /// after the last accepted step, when the step has been cut below the smallest allowed.
  void advance(double largest = std::numeric_limits<double>::infinity()) {
    for (;;) {
      const double size = std::min({strain, options.max_strain, largest});
      if (try_step(size)) return;
      strain = 0.5 * size;
      ++n_failed;
      if (strain < options.min_strain)
        throw NotConverged("compaction: step " + std::to_string(n_steps + 1) + " at packing fraction " +
                           std::to_string(packing_fraction()) + " failed down to a strain of " +
                           std::to_string(strain) + ": " + report.reason +
                           "; try a finer mesh, a smaller friction or a smaller --every");
    }
  }

  /// A step of exactly this strain; false when it did not converge.
  bool try_step(double size) {
    const double shrink = std::exp(-size / Dim);
    auto& room = packing.room;
    double distance = 0;
    for (const double d : room.distance) distance += d / double(room.n_walls());
    const double young = packing.model->material.young;
    const double pressure = std::max(last_pressure / young, options.least_pressure);
    // At high pressure the walls may run faster: inertia stays as small beside P, and steadies the step.
    const double number =
        std::min(std::sqrt(options.kinetic_ratio * pressure),
                 std::max(options.inertial_number, std::sqrt(1e-2 * options.kinetic_ratio * pressure)));
    const double speed = number * std::sqrt(young / packing.model->material.density);
    const double h = (1 - shrink) * room.scale * distance / speed;
    Array<typename Packing::Nodal> position, velocity;
    for (const auto& grain : packing.grains) {
      position.push_back(grain.position);
      velocity.push_back(grain.velocity);
    }
    const auto attempt = step.advance(packing, h, shrink * room.scale);
    n_iterations += attempt.iterations;
    n_linear_iterations += attempt.linear_iterations;
    report = attempt;
    if (!attempt.converged) return false;
    ++n_steps;
    last_duration = h;
    position_before = std::move(position);
    velocity_before = std::move(velocity);
    last_pressure = std::max(0.0, this->pressure());
    if (attempt.iterations <= options.easy_iterations)
      strain =
          std::max(strain, std::min((attempt.iterations <= options.easy_iterations / 2 ? 2.0 : 1.3) * size,
                                    options.max_strain));
    return true;
  }
};

}  // namespace jampack
