// SPDX-License-Identifier: MIT
// Contact problems of packings of deformable grains: the first one of the next step from each checkpoint is
// saved in the text format, and every solver is measured on it (work_precision_solvers says how), from zero
// and from the forces of the checkpoint, with W as one compliance a grain, as steps have it. The same with W
// as stored blocks: work_precision_solvers on the files written. Everything goes to the working folder.
#include <filesystem>
#include <jampack/element/macro_simplex.hpp>
#include <jampack/io/checkpoint_compaction.hpp>
#include <jampack/io/contact_problem_text.hpp>

#include "solver_curves.hpp"

using namespace jampack;
using namespace jampack_bench;

namespace {

template <int Dim>
void measure(const std::string& name, const StoredState<Dim>& state, SolverCurves& curves) {
  using Packing = SoftPacking<Dim, MacroSimplex<Dim>, NeoHookean>;
  const SignoriniCoulomb law{.friction = state.friction};
  SoftStepOptions step_options;
  step_options.theta = state.theta;
  auto run = restored_compaction<Packing>(state, law, CompactionOptions{}, step_options);
  const double strain = std::min(run.strain, run.options.max_strain);
  const auto condensed = run.contact_problem(strain);
  const auto& problem = condensed.problem;
  write_contact_problem(name + ".txt", problem, condensed.guess);
  std::printf("%s: phi %.4f, %td grains, next strain %.1e, %td pairs, %td walls, %td unknowns\n",
              name.c_str(), run.packing_fraction(), state.grains.size(), strain, condensed.pairs.size(),
              condensed.walls.size(), condensed.guess.size());
  const Array<std::string> solvers = {
      "default", "sweeps", "sweeps_shuffled", "sweeps_coloured", "proximal_newton", "proximal_newton_soft",
      "admm"};
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(condensed.guess.size());
  curves.measure(name + "_grains", problem, zero, solvers);
  curves.measure(name + "_grains_warm", problem, condensed.guess, solvers);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::puts("soft_contact_problems CHECKPOINT ...   solvers on the contact problems of deformable grains");
    return 2;
  }
  SolverCurves curves("soft_contact_problems.csv", 15);
  for (int k = 1; k < argc; ++k) {
    const std::string name = std::filesystem::path(argv[k]).stem().string();
    std::visit([&](const auto& state) { measure(name, state, curves); }, read_checkpoint(argv[k]));
  }
}
