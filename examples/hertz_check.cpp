// SPDX-License-Identifier: MIT
// One grain pressed between two plane walls without friction: its force beside Hertz's and beside the
// finite-strain reference (docs/theory/compaction_laws.md).
#include <cmath>
#include <filesystem>
#include <iostream>
#include <jampack/analysis/hertz.hpp>
#include <jampack/analysis/hertz_cylinder.hpp>
#include <jampack/analysis/sphere_compression_reference.hpp>
#include <jampack/element/linear_simplex.hpp>
#include <jampack/element/macro_simplex.hpp>
#include <jampack/element/quadratic_simplex.hpp>
#include <jampack/io/command_line.hpp>
#include <jampack/io/csv_writer.hpp>
#include <jampack/io/progress.hpp>
#include <jampack/io/run_program.hpp>
#include <jampack/law/signorini.hpp>
#include <jampack/material/neo_hookean.hpp>
#include <jampack/mesh/ball_mesh.hpp>
#include <jampack/mesh/disk_mesh.hpp>
#include <jampack/solver/contact_solver.hpp>
#include <jampack/stepping/soft_step.hpp>

using namespace jampack;

namespace {

const Array<std::string> element_names = {"linear", "macro", "quadratic", "resisting"};

struct Parameters {
  Index dim = 3, cells = 808, threads = 1;
  std::string element = "macro", out = ".";
  double poisson = 0.495, strain = 0.1;
};

/// Force of Hertz's law at approach delta of one contact of a grain of unit diameter and modulus; NaN where
/// it ends.
template <int Dim>
double hertz_force(double delta, double poisson) {
  if constexpr (Dim == 3) return hertz_sphere_on_plane({1, 1, poisson}).force(delta);
  try {
    return CylinderBetweenPlates{1, 1, poisson}.force(delta);
  } catch (const InvalidInput&) {
    return std::numeric_limits<double>::quiet_NaN();
  }
}

template <int Dim, class Element>
int check(const Parameters& p, const Mesh<Dim>& mesh, Json& summary) {
  using Packing = SoftPacking<Dim, Element, NeoHookean>;
  const Stopwatch clock;
  Packing packing(mesh, NeoHookean{.young = 1, .poisson = p.poisson}, plates<Dim>(1.0));
  packing.add(1.0, Vector<Dim>::Zero());
  SoftStepOptions options;
  options.threads.count = static_cast<int>(p.threads);
  SoftStep<Packing, Signorini> step(Signorini{}, options);

  const std::filesystem::path folder = p.out;
  CsvWriter table(folder / "hertz.csv", {"delta_over_d", "force", "hertz_force", "reference_force",
                                         "error_to_reference", "seconds"});
  Progress progress;
  progress.phase("hertz_check", p.strain);
  const double none = std::numeric_limits<double>::quiet_NaN();
  const Index n_rows = 16;
  const double first = std::min(1e-3, 0.05 * p.strain);
  double reached = 0, worst = 0;
  summary["cells"] = mesh.cells.size();
  for (Index row = 0; row < n_rows; ++row) {
    const double target = first * std::pow(p.strain / first, double(row) / double(n_rows - 1));
    for (double length = std::min(target - reached, 0.01); reached < target;) {
      const double delta = target - reached <= length * 1.001 ? target : reached + length;
      // Wave crossing times: long enough for inertia to be nothing beside the force, short enough for it to
      // keep the grain from sliding and rolling along the walls, which have no friction.
      const double slow = 100;
      for (auto& grain : packing.grains) grain.velocity.setZero();
      const auto report = step.advance(packing, slow, 1 - 2 * delta);
      if (report.converged) {
        reached = delta;
        continue;
      }
      length *= 0.5;
      if (length < 1e-7)
        throw NotConverged("delta/d = " + to_text(delta) + ": " + report.reason +
                           "; try another element or more cells");
    }
    double force = 0;  // mean of the two walls
    for (Index c = 0; c < step.contacts.walls.size(); ++c) force += 0.5 * step.contacts.walls.reaction[c][0];
    double reference = none;
    if constexpr (Dim == 3) reference = sphere_compression_force({1, 1, p.poisson}, target).value_or(none);
    const double error = force / reference - 1;
    if (std::abs(error) > worst) worst = std::abs(error);
    table.write({target, force, hertz_force<Dim>(target, p.poisson), reference, error, clock.seconds()});
    progress.show(target, {{"delta/d", target}, {"force", force}, {"error", error}});
  }
  progress.finish();
  summary["worst_error_to_reference"] = worst;
  summary["seconds"] = clock.seconds();
  return 0;
}

template <int Dim>
int check(const Parameters& p, const Mesh<Dim>& mesh, Json& summary) {
  if (p.element == "linear") return check<Dim, LinearSimplex<Dim>>(p, mesh, summary);
  if (p.element == "quadratic") return check<Dim, QuadraticSimplex<Dim>>(p, mesh, summary);
  if (p.element == "resisting") return check<Dim, ResistingSimplex<Dim>>(p, mesh, summary);
  return check<Dim, MacroSimplex<Dim>>(p, mesh, summary);
}

int hertz_check(CommandLine& line) {
  Parameters p;
  bool list = false;
  line.option("dim", p.dim, from_to(2, 3), "disk or sphere");
  line.option("element", p.element, element_names, "finite element");
  line.option("cells", p.cells, at_least(64), "linear elements, nearest there is");
  line.option("poisson", p.poisson, strictly_between(-1, 0.5),
              "Poisson's ratio; the reference has 0.495, 0.3");
  line.option("strain", p.strain, OptionRange{.lower = 0, .upper = 0.4, .upper_included = true},
              "largest delta/d, delta the approach at one contact");
  line.option("out", p.out, "folder for hertz.csv and summary.json");
  line.option("threads", p.threads, from_to(1, 4096), "threads");
  line.flag("list", list, "names the elements");
  if (!line.parse()) return 0;
  if (list) {
    for (const auto& name : element_names) std::cout << name << "\n";
    return 0;
  }
  make_output_folder(p.out);
  Json summary = Json::object();
  summary["parameters"] = line.parameters();
  const int code = p.dim == 2 ? check(p, disk_mesh(p.cells), summary) : check(p, ball_mesh(p.cells), summary);
  write_file(std::filesystem::path(p.out) / "summary.json", summary.text());
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  return run_program(argc, argv, "presses one grain between two walls, beside Hertz", hertz_check);
}
