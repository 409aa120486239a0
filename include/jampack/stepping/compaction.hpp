// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <jampack/analysis/granular_stress.hpp>
#include <jampack/analysis/soft_network.hpp>
#include <jampack/body/surface_measure.hpp>
#include <jampack/stepping/soft_step.hpp>
#include <optional>
#include <utility>

namespace jampack {

/// How fast and in which steps a packing is pressed.
struct CompactionOptions {
  double kinetic_ratio = 1e-5;    ///< rho v0^2 / P, with v0 the speed of each wall
  double least_pressure = 1e-3;   ///< P / E that it reckons with where there is less
  double inertial_number = 1e-2;  ///< bound on I = v0 sqrt(rho / E)
  double first_strain = 1e-3;     ///< first volumetric strain step, -d ln V
  double max_strain = 0.01;       ///< largest step
  double min_strain = 1e-7;       ///< below this the compaction is given up
  int easy_iterations = 30;       ///< a step that needed no more may be followed by a larger one
  double settled = 8e-4;          ///< imbalance of a grain, |sum F| / sum |F|, at which it has settled
  double settled_afresh = 3e-4;   ///< residual of balance, contact detected afresh, to which it should settle
  Index max_settling_steps = 60;  ///< before a packing is said not to settle
};

/// Presses a packing by homothetic closing of its room at constant wall speed, in adaptive implicit steps:
/// a step that fails is cut, one that was easy lets the next grow.
template <class Packing, ContactLaw Law, class Solver = ProximalNewton, class Discretisation = SampledContact>
class Compaction {
 public:
  static constexpr int Dim = Packing::dimension;

  Packing packing;
  SoftStep<Packing, Law, Solver, Discretisation> step;
  CompactionOptions options;

  Index n_steps = 0;
  Index n_iterations = 0;
  Index n_failed = 0;
  // What a resumed run needs:
  double strain = 0;         ///< size of the next step
  double last_duration = 0;  ///< h of the last accepted step
  double last_pressure = 0;  ///< after it, >= 0
  double gain = 1;           ///< growth of ln phi over strain, of the last step of advance_to()
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
    return contact_network<Packing, Dim>(packing, step.contacts.pairs, step.contacts.walls);
  }
  double pressure() const { return granular_pressure(network()); }

  /// One accepted step of at most `largest` volumetric strain; where steps fail down to small ones the walls
  /// are held first until the grains have settled. Throws NotConverged, the packing being as
  /// after the last accepted step, when the step has been cut below the smallest allowed.
  void advance(double largest = std::numeric_limits<double>::infinity()) {
    for (bool held = false;;) {
      const double size = std::min({strain, options.max_strain, largest});
      if (try_step(size)) return;
      strain = 0.5 * size;
      ++n_failed;
      // A packing on its way down from an unstable equilibrium needs time, not strain.
      if (strain < 1e-3 * options.max_strain && !held) {
        held = true;
        settle();
        strain = options.first_strain;
      }
      if (strain < options.min_strain)
        throw NotConverged("compaction: step " + std::to_string(n_steps + 1) + " at packing fraction " +
                           std::to_string(packing_fraction()) + " failed down to a strain of " +
                           std::to_string(strain) + ": " + report.reason +
                           "; try a finer mesh, a smaller friction or a smaller --every");
    }
  }

  /// Even steps, each at most as large as is wise, until the packing fraction is at most `missing` below
  /// `target`: grains are compressible, and what the last step misses need not be worth another.
  /// `progress(run)` is called after each. Throws as advance() does.
  template <class Progress>
  void advance_to(double target, double missing, Progress&& progress) {
    constexpr double least_gain = 0.2, least_strain = 1e-5;
    for (double phi = packing_fraction(); phi < target - missing;) {
      const double needed = std::max(std::log(target / phi) / gain, least_strain);
      const double wise = std::min(strain, options.max_strain);
      const double scale = packing.room.scale, before = phi;
      advance(needed / std::ceil(needed / wise));
      phi = packing_fraction();
      gain =
          std::clamp(std::log(phi / before) / (Dim * std::log(scale / packing.room.scale)), least_gain, 1.0);
      progress(std::as_const(*this));
    }
  }
  void advance_to(double target, double missing) {
    advance_to(target, missing, [](const auto&) {});
  }

  /// A step of exactly this strain; false when it did not converge.
  bool try_step(double size) {
    const double scale = std::exp(-size / Dim) * packing.room.scale;
    if (!step_to(scale, duration(size), [&] { return start_flow(); })) return false;
    if (report.iterations <= options.easy_iterations)
      strain =
          std::max(strain, std::min((report.iterations <= options.easy_iterations / 2 ? 2.0 : 1.3) * size,
                                    options.max_strain));
    return true;
  }

  /// The first contact problem of a step of this strain; nothing moves. Throws NotConverged where a grain
  /// cannot be linearised.
  auto contact_problem(double size) {
    const auto before = packing.grains;
    const double h = duration(size);
    const FirstGuess guess = start_flow();
    Packing start = packing;
    packing.grains = before;
    return step.contact_problem(std::move(start), h, std::exp(-size / Dim) * packing.room.scale, guess);
  }

  /// Holds the walls until the grains balance: steps from rest, ever longer, so that inertia fades;
  /// `progress(run)` is called after each. False when that did not succeed; the packing is then as after the
  /// last step that converged.
  template <class Progress>
  bool settle(Progress&& progress) {
    struct Restore {
      SoftStepOptions& options;
      const SoftStepOptions saved;
      ~Restore() { options = saved; }
    } restore{step.options, step.options};
    // What does not converge soon is on a long way down; it is kept.
    step.options.max_iterations = std::min(step.options.max_iterations, 30);
    return settle_in_steps(progress);
  }
  bool settle() {
    return settle([](const auto&) {});
  }

  /// One step of duration h in which the room's scale goes to `scale`, and what is kept of it; `prepare` may
  /// change velocities first, and returns the first guess. False when it did not converge; the packing is
  /// then as it was, unless it was to be kept and came near (`report.kept`).
  template <class Prepare>
  bool step_to(double scale, double h, Prepare prepare, Unfinished unfinished = Unfinished::undone) {
    Array<typename Packing::Nodal> position, velocity, unprepared;
    for (const auto& grain : packing.grains) unprepared.push_back(grain.velocity);
    const FirstGuess guess = prepare();
    for (const auto& grain : packing.grains) {
      position.push_back(grain.position);
      velocity.push_back(grain.velocity);
    }
    report = step.advance(packing, h, scale, guess, unfinished);
    n_iterations += report.iterations;
    if (!report.converged && !report.kept) {
      for (Index g = 0; g < packing.grains.size(); ++g) packing.grains[g].velocity = unprepared[g];
      return false;
    }
    ++n_steps;
    last_duration = h;
    position_before = std::move(position);
    velocity_before = std::move(velocity);
    last_pressure = std::max(0.0, pressure());
    return report.converged;
  }

  /// Of the walls from the centre, at scale 1.
  double mean_wall_distance() const {
    double sum = 0;
    for (const double d : packing.room.distance) sum += d;
    return sum / double(packing.room.n_walls());
  }

 private:
  template <class Progress>
  bool settle_in_steps(Progress&& progress) {
    const double shortest = duration(options.min_strain);
    double h = duration(options.max_strain);
    // In longer steps masses are lost in round-off.
    const auto& material = packing.model->material;
    const double most = 1e4 * packing.mean_diameter() * std::sqrt(material.density / material.young);
    double longest = most;  // what failed is tried again only little by little
    bool converged = true;
    std::optional<Accepted> last;  // step that converged, where a later one did not but was kept
    const auto step_from_rest = [&](Unfinished unfinished) {
      return step_to(
          packing.room.scale, h,
          [&] {
            for (auto& grain : packing.grains) grain.velocity.setZero();
            return FirstGuess::rest;
          },
          unfinished);
    };
    Index n_fresh = 0;  // steps made only for frames: some turn with every solution
    for (Index k = 0; k < options.max_settling_steps && h > shortest; ++k) {
      if (converged && grain_imbalance(network()) <= options.settled &&
          (report.fresh <= options.settled_afresh || ++n_fresh > 2))
        return true;
      if (converged) last = accepted();
      converged = step_from_rest(Unfinished::kept);
      if (converged) {
        // A grain that carries next to nothing is not seen in the residual of all.
        if (report.iterations == 0) step.options.tolerance = std::max(0.1 * step.options.tolerance, 1e-10);
        if (report.iterations <= options.easy_iterations)
          h = std::min((report.iterations <= options.easy_iterations / 2 ? 4 : 2) * h, longest);
        longest = std::min(1.5 * longest, most);
      } else {
        ++n_failed;
        longest = 0.5 * h;
        h *= report.kept ? 0.5 : 0.2;
      }
      progress(std::as_const(*this));
    }
    // What is left behind must be the end of a step.
    for (; !converged && h > 0.01 * shortest; h *= 0.2) converged = step_from_rest(Unfinished::undone);
    if (!converged) go_back(*last);
    return converged && grain_imbalance(network()) <= options.settled;
  }

  /// What a step changes that can be taken back.
  struct Accepted {
    Packing packing;
    typename SoftStep<Packing, Law, Solver, Discretisation>::Watched contacts;
    Array<typename Packing::Nodal> position_before, velocity_before;
    double duration, pressure;
  };
  Accepted accepted() const {
    return {packing, step.contacts, position_before, velocity_before, last_duration, last_pressure};
  }
  void go_back(const Accepted& to) {
    packing = to.packing;
    step.contacts = to.contacts;
    position_before = to.position_before;
    velocity_before = to.velocity_before;
    last_duration = to.duration;
    last_pressure = to.pressure;
  }

  /// Of a step of volumetric strain `size`.
  double duration(double size) const {
    return (1 - std::exp(-size / Dim)) * packing.room.scale * mean_wall_distance() / wall_speed();
  }
  double wall_speed() const {
    const double young = packing.model->material.young;
    const double pressure = std::max(last_pressure / young, options.least_pressure);
    return std::min(options.inertial_number, std::sqrt(options.kinetic_ratio * pressure)) *
           std::sqrt(young / packing.model->material.density);
  }

  /// Gives grains that were at rest the flow that goes with the closing walls.
  FirstGuess start_flow() {
    const Vector<Dim>& origin = packing.room.centre;
    double flow = 0, size = 0;
    for (const auto& grain : packing.grains) {
      const Vector<Dim> r = grain.centre() - origin;
      flow += r.dot(grain.velocity.rowwise().mean());
      size += r.squaredNorm();
    }
    const double rate = -wall_speed() / (packing.room.scale * mean_wall_distance());
    if (flow < 0.5 * rate * size) return FirstGuess::flight;
    for (auto& grain : packing.grains) {
      const Vector<Dim> missing = (rate - flow / std::max(size, 1e-300)) * (grain.centre() - origin);
      grain.velocity.colwise() += missing;
    }
    return FirstGuess::rest;
  }
};

}  // namespace jampack
