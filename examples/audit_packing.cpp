// SPDX-License-Identifier: MIT
// Audits a stored packing: recomputes by brute force, from the checkpoint alone, what must be true of it.
// One line a quantity; exit code 1 if one is out of bounds.
#include <cstdio>
#include <jampack/analysis/audit.hpp>
#include <jampack/element/linear_simplex.hpp>
#include <jampack/element/macro_simplex.hpp>
#include <jampack/element/quadratic_simplex.hpp>
#include <jampack/io/checkpoint.hpp>
#include <jampack/io/command_line.hpp>
#include <jampack/io/run_program.hpp>
#include <jampack/material/linear_elastic.hpp>
#include <jampack/material/neo_hookean.hpp>

using namespace jampack;

namespace {

template <class Element, int Dim>
AuditReport audit_material(const StoredState<Dim>& state, Threads threads) {
  if (state.material == "neo_hookean") return audit<Element, NeoHookean>(state, threads);
  if (state.material == "neo_hookean_quadratic") return audit<Element, NeoHookeanQuadratic>(state, threads);
  if (state.material == "linear_elastic") return audit<Element, LinearElastic>(state, threads);
  throw InvalidInput("the checkpoint has a material this program does not know: " + state.material);
}

template <int Dim>
AuditReport audit_element(const StoredState<Dim>& state, Threads threads) {
  if (state.element == LinearSimplex<Dim>::name) return audit_material<LinearSimplex<Dim>>(state, threads);
  if (state.element == MacroSimplex<Dim>::name) return audit_material<MacroSimplex<Dim>>(state, threads);
  if (state.element == QuadraticSimplex<Dim>::name)
    return audit_material<QuadraticSimplex<Dim>>(state, threads);
  if (state.element == ResistingSimplex<Dim>::name)
    return audit_material<ResistingSimplex<Dim>>(state, threads);
  throw InvalidInput("the checkpoint has an element this program does not know: " + state.element);
}

int audit_packing(CommandLine& line) {
  std::string file;
  Threads threads;
  AuditBounds bounds;
  line.argument("CHECKPOINT", file, "a state written by compact_spheres or compact_disks");
  line.option("threads", threads.count, from_to(1, 1024), "threads");
  line.option("balance-pressure", bounds.balance_pressure, at_least(0),
              "pressure above which grain_imbalance and wall_imbalance are held to their bounds");
  if (!line.parse()) return 0;
  const AnyStoredState any = read_checkpoint(file);
  const AuditReport report =
      std::visit([&](const auto& state) { return audit_element(state, threads); }, any);
  if (!line.given("balance-pressure"))
    std::visit(
        [&](const auto& state) {
          // A run says at which stress it was prepared: balance means something well above it.
          const auto stress = state.parameters.find("preparation_stress");
          if (stress == state.parameters.end()) return;
          if (const auto number = to_number<double>(stress->second)) bounds.balance_pressure = 10 * *number;
        },
        any);
  for (const auto& row : report.rows(bounds)) {
    std::printf("%-24s %13.6e", row.name.c_str(), row.value);
    if (row.name == "min_J")
      std::printf("  > 0        %s", row.is_good ? "ok" : "OUT OF BOUNDS");
    else if (row.bound == row.bound)
      std::printf("  <= %-7.1e %s", row.bound, row.is_good ? "ok" : "OUT OF BOUNDS");
    std::printf("\n");
  }
  return report.is_good(bounds) ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  return run_program(argc, argv, "audits a stored packing by brute force", audit_packing);
}
