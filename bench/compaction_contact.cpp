// SPDX-License-Identifier: MIT
// One compaction of spheres by either contact discretisation: pressure, CPU time, and how deep grains lie in
// each other, by the audit's own surfaces.
#include <algorithm>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <jampack/analysis/audit_penetration.hpp>
#include <jampack/detection/weighted_contact.hpp>
#include <jampack/element/linear_simplex.hpp>
#include <jampack/element/macro_simplex.hpp>
#include <jampack/io/command_line.hpp>
#include <jampack/io/csv_writer.hpp>
#include <jampack/io/run_program.hpp>
#include <jampack/law/signorini_coulomb.hpp>
#include <jampack/material/neo_hookean.hpp>
#include <jampack/mesh/ball_mesh.hpp>
#include <jampack/packing/handover.hpp>
#include <jampack/stepping/jam.hpp>
#include <jampack/stepping/press_to.hpp>

#include "measure.hpp"

using namespace jampack;

namespace {

struct Options {
  Index grains = 20, cells = 400, seed = 1;
  double until = 0.92, every = 0.02;
  std::string element = "macro", contact = "weighted", out = ".";
};

constexpr double preparation_stress = 1e-5;  // over E

template <template <int> class Element, class Discretisation>
void compact(const Options& options, CsvWriter& table) {
  using Packing = SoftPacking<3, Element<3>, NeoHookean>;
  const SignoriniCoulomb law{0.3};
  const auto loose =
      random_packing<3>({.n_grains = options.grains, .seed = static_cast<std::uint64_t>(options.seed)});
  const auto jammed = jam(loose, law, {.stress = preparation_stress});
  Compaction<Packing, SignoriniCoulomb, ProximalNewton, Discretisation> run(
      meshed_grains<Element>(jammed.packing, ball_mesh(options.cells),
                             NeoHookean{.young = 1, .poisson = 0.495}),
      law, {}, {});
  double seconds = 0;  // without the audit
  const auto timed = [&](auto&& work) {
    const double start = jampack_bench::cpu_seconds();
    work();
    seconds += jampack_bench::cpu_seconds() - start;
  };
  std::cout << "     phi         P/E   steps  problems  contacts  imbalance     depth   overlap     CPU s\n";
  const auto record = [&] {
    Array<AuditSurface<3>> surfaces;
    for (const auto& grain : run.packing.grains)
      surfaces.emplace_back(run.packing.model->mesh, grain.position);
    const double d = run.packing.mean_diameter();
    const auto lies = audit_penetration(surfaces, run.packing.room, 0.05 * d, 1e-3 * d, Threads{});
    const auto& forces = run.step.contacts.pairs.reaction;
    const auto loaded =
        std::count_if(forces.begin(), forces.end(), [](const auto& r) { return !r.isZero(0); });
    const double phi = run.packing_fraction(), pressure = run.pressure(), depth = lies.depth / d,
                 overlap = lies.overlap / run.solid_volume(), imbalance = grain_imbalance(run.network());
    std::cout << std::fixed << std::setprecision(4) << std::setw(8) << phi << std::scientific
              << std::setprecision(3) << std::setw(12) << pressure << std::setw(8) << run.n_steps
              << std::setw(10) << run.n_iterations << std::setw(10) << loaded << std::setprecision(1)
              << std::setw(11) << imbalance << std::setw(10) << depth << std::setw(10) << overlap
              << std::fixed << std::setw(10) << seconds << std::endl;
    table.write({options.element, options.contact, options.grains, options.cells, options.seed, phi, pressure,
                 run.n_steps, run.n_iterations, static_cast<Index>(loaded), imbalance, depth, overlap,
                 seconds, jampack_bench::compiler(), jampack_bench::flags(), jampack_bench::commit()});
    return phi;
  };
  timed([&] { press_to(run, {.stress = preparation_stress}); });
  for (double phi = record(); phi < options.until; phi = record())
    timed([&] {
      const double beyond = 0.05 * options.every;
      run.advance_to(std::min(phi + options.every, options.until + beyond), beyond);
      if (!run.settle()) std::cout << "not settled:\n";
    });
}

void compaction_contact(CommandLine& line) {
  Options options;
  line.option("grains", options.grains, at_least(2), "number of grains");
  line.option("cells", options.cells, at_least(32), "linear elements a grain, nearest there is");
  line.option("until", options.until, strictly_between(0, 1), "last packing fraction");
  line.option("every", options.every, strictly_between(0, 1), "packing fraction between records");
  line.option("seed", options.seed, at_least(0), "of the random packing");
  line.option("element", options.element, Array<std::string>{"linear", "macro"}, "finite element");
  line.option("contact", options.contact, Array<std::string>{"sampled", "weighted"},
              "contact discretisation");
  line.option("out", options.out, "folder for compaction_contact.csv");
  if (!line.parse()) return;
  make_output_folder(options.out);
  CsvWriter table(std::filesystem::path(options.out) / "compaction_contact.csv",
                  {"element", "contact", "grains", "cells", "seed", "phi", "P_over_E", "steps", "problems",
                   "loaded_contacts", "grain_imbalance", "max_penetration_over_d", "overlap_over_solid",
                   "cpu_seconds", "compiler", "flags", "commit"});
  const bool weighted = options.contact == "weighted";
  if (options.element == "linear")
    weighted ? compact<LinearSimplex, WeightedContact>(options, table)
             : compact<LinearSimplex, SampledContact>(options, table);
  else
    weighted ? compact<MacroSimplex, WeightedContact>(options, table)
             : compact<MacroSimplex, SampledContact>(options, table);
}

}  // namespace

int main(int argc, char** argv) {
  return run_program(argc, argv, "presses spheres by either contact discretisation", compaction_contact);
}
