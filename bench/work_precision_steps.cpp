// SPDX-License-Identifier: MIT
// Error of P(phi) against CPU time over the size of the steps, the speed of the walls and the tolerances: one
// packing is jammed, meshed and pressed to sigma0 once, and compacted from there with each setting, every
// other being the default. The reference is a run with finer steps, slower walls and lower tolerances than
// any. Every record is settled, as the programs' are.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <jampack/element/macro_simplex.hpp>
#include <jampack/io/command_line.hpp>
#include <jampack/io/csv_writer.hpp>
#include <jampack/io/run_program.hpp>
#include <jampack/law/signorini_coulomb.hpp>
#include <jampack/material/neo_hookean.hpp>
#include <jampack/mesh/ball_mesh.hpp>
#include <jampack/mesh/disk_mesh.hpp>
#include <jampack/packing/handover.hpp>
#include <jampack/packing/random_packing.hpp>
#include <jampack/stepping/jam.hpp>
#include <jampack/stepping/press_to.hpp>
#include <limits>

#include "measure.hpp"

using namespace jampack;

namespace {

struct Options {
  Index dimension = 2, grains = 20, cells = 100, seed = 1;
  double until = 0.9, every = 0.005;
  std::string settings, out = ".";
};

/// Factors on the defaults.
struct Setting {
  std::string name;
  double step = 1, speed = 1, tolerance = 1;
};

struct Curve {
  Array<double> phi, pressure;
  double seconds = 0;
  Index steps = 0, iterations = 0, failed = 0;
  std::string failure;

  /// ln P by linear interpolation; NaN outside the curve.
  double log_pressure(double at) const {
    for (Index i = 1; i < phi.size(); ++i)
      if (phi[i - 1] <= at && at <= phi[i]) {
        const double t = (at - phi[i - 1]) / (phi[i] - phi[i - 1]);
        return (1 - t) * std::log(pressure[i - 1]) + t * std::log(pressure[i]);
      }
    return std::numeric_limits<double>::quiet_NaN();
  }
};

template <class Run>
Curve compact(Run run, const Options& options) {
  Curve curve;
  curve.phi = {run.packing_fraction()};
  curve.pressure = {run.pressure()};
  const double start = jampack_bench::cpu_seconds();
  try {
    while (curve.phi.back() < options.until) {
      run.advance_to(curve.phi.back() + options.every, 0.1 * options.every);
      run.settle();
      curve.phi.push_back(run.packing_fraction());
      curve.pressure.push_back(run.pressure());
    }
  } catch (const NotConverged& error) {
    curve.failure = error.what();
  }
  curve.seconds = jampack_bench::cpu_seconds() - start;
  curve.steps = run.n_steps;
  curve.iterations = run.n_iterations;
  curve.failed = run.n_failed;
  return curve;
}

template <int Dim>
void measure(const Options& options, const Mesh<Dim>& mesh) {
  using Packing = SoftPacking<Dim, MacroSimplex<Dim>, NeoHookean>;
  using Run = Compaction<Packing, SignoriniCoulomb>;
  const SignoriniCoulomb law{.friction = 0.3};
  const double stress = 1e-5;
  const auto loose =
      random_packing<Dim>({.n_grains = options.grains, .seed = static_cast<std::uint64_t>(options.seed)});
  const auto jammed = jam(loose, law, {.stress = stress});
  Run pressed(meshed_grains<MacroSimplex>(jammed.packing, mesh, NeoHookean{.young = 1, .poisson = 0.495}),
              law);
  press_to(pressed, {.stress = stress});

  const auto curve_of = [&](const Setting& setting) {
    Run run = pressed;
    run.options.max_strain *= setting.step;
    run.options.first_strain = std::min(run.options.first_strain, run.options.max_strain);
    run.strain = std::min(run.strain, run.options.max_strain);
    run.options.kinetic_ratio *= setting.speed * setting.speed;
    for (double* tolerance : {&run.step.options.tolerance, &run.step.options.scaled_tolerance,
                              &run.step.options.surface_tolerance})
      *tolerance *= setting.tolerance;
    run.n_steps = run.n_iterations = run.n_failed = 0;
    return compact(std::move(run), options);
  };

  const Array<Setting> settings{{"default"},
                                {"step x 2", 2},
                                {"step / 2", 0.5},
                                {"step / 4", 0.25},
                                {"speed x 10", 1, 10},
                                {"speed x 3", 1, 3},
                                {"speed / 2", 1, 0.5},
                                {"tolerance x 100", 1, 1, 100},
                                {"tolerance x 10", 1, 1, 10},
                                {"tolerance / 10", 1, 1, 0.1}};
  const Curve reference = curve_of({"reference", 0.125, 0.5, 0.1});
  const double from = reference.phi.front() + 0.05;
  CsvWriter table(std::filesystem::path(options.out) / "work_precision_steps.csv",
                  {"dimension", "grains", "cells", "seed", "setting", "step", "speed", "tolerance", "reached",
                   "steps", "iterations", "failed_steps", "cpu_seconds", "error_max", "error_rms",
                   "largest_drop", "compiler", "flags", "commit"});
  const auto report = [&](const Setting& setting, const Curve& curve) {
    double largest = 0, squares = 0, drop = 0, n = 0;
    for (Index i = 0; i < reference.phi.size(); ++i) {
      const double error =
          std::abs(std::expm1(curve.log_pressure(reference.phi[i]) - std::log(reference.pressure[i])));
      if (reference.phi[i] < from || std::isnan(error)) continue;
      largest = std::max(largest, error);
      squares += error * error;
      ++n;
    }
    for (Index i = 1; i < curve.phi.size(); ++i)
      if (curve.phi[i] > from) drop = std::max(drop, 1 - curve.pressure[i] / curve.pressure[i - 1]);
    const double rms = std::sqrt(squares / n);
    table.write({Dim, options.grains, options.cells, options.seed, setting.name, setting.step, setting.speed,
                 setting.tolerance, curve.phi.back(), curve.steps, curve.iterations, curve.failed,
                 curve.seconds, largest, rms, drop, jampack_bench::compiler(), jampack_bench::flags(),
                 jampack_bench::commit()});
    std::cout << std::setw(16) << setting.name << std::fixed << std::setprecision(3) << std::setw(9)
              << curve.phi.back() << std::setw(7) << curve.steps << std::setw(8) << curve.iterations
              << std::setw(8) << curve.failed << std::setprecision(1) << std::setw(9) << curve.seconds
              << std::setprecision(2) << std::setw(10) << 100 * largest << std::setw(8) << 100 * rms
              << std::setw(8) << 100 * drop << (curve.failure.empty() ? "" : "  stopped: " + curve.failure)
              << std::endl;
  };
  std::cout << "         setting  reached  steps   iter.  failed    CPU s  max err % rms err %  drop %\n";
  report({"reference", 0.125, 0.5, 0.1}, reference);
  for (const Setting& setting : settings)
    if (jampack_bench::named(options.settings, setting.name)) report(setting, curve_of(setting));
}

void work_precision(CommandLine& line) {
  Options options;
  line.option("dimension", options.dimension, from_to(2, 3), "2: disks, 3: spheres");
  line.option("grains", options.grains, at_least(1), "number of grains");
  line.option("cells", options.cells, at_least(32), "linear elements a grain, nearest there is");
  line.option("seed", options.seed, at_least(0), "of the random packing");
  line.option("until", options.until, strictly_between(0, 1.2), "packing fraction to reach");
  line.option("every", options.every, strictly_between(0, 1), "packing fraction between records");
  line.option("settings", options.settings, "names of the settings, separated by commas; all by default");
  line.option("out", options.out, "folder for work_precision_steps.csv");
  if (!line.parse()) return;
  if (options.dimension == 2)
    measure<2>(options, disk_mesh(options.cells));
  else
    measure<3>(options, ball_mesh(options.cells));
}

}  // namespace

int main(int argc, char** argv) {
  return run_program(argc, argv,
                     "measures the error of P(phi) against CPU time over steps, speed and tolerances",
                     work_precision);
}
