// SPDX-License-Identifier: MIT
// More problems of the families of given ones: loads moved by W xi, which leaves a feasible problem feasible,
// and friction changed. The default solver on each, to 1e-8 in `residual` and `scaled_residual`. Prints those
// that were not solved or took longest, writes fclib_families.csv.
//   fclib_families FILE.hdf5 ... [--variants N]      needs HDF5
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <jampack/core/splitmix.hpp>
#include <jampack/io/csv_writer.hpp>
#include <jampack/solver/default_solver.hpp>
#include <string>
#include <variant>

#include "measure.hpp"
#ifdef JAMPACK_WITH_HDF5
#include <jampack/io/fclib.hpp>

using namespace jampack;

namespace {

double uniform(std::uint64_t& state) {  // in [-1, 1)
  return static_cast<double>(splitmix(state) >> 11) * 0x1p-52 - 1;
}

// q + W xi with |rho W xi| of the given size relative to |rho q|, and friction times 0.7 to 1.3.
template <class Problem>
Problem variant(const Problem& problem, double size, std::uint64_t& state) {
  constexpr int N = Problem::n_unknowns;
  Problem changed = problem;
  const Array<double> rho = natural_map_steps(problem);
  const auto norm = [&](const Eigen::VectorXd& u) {
    double sum = 0;
    for (Index c = 0; c < rho.size(); ++c)
      sum += rho[c] * rho[c] * u.template segment<N>(N * c).squaredNorm();
    return std::sqrt(sum);
  };
  const Eigen::VectorXd xi =
      Eigen::VectorXd::NullaryExpr(problem.free_velocity.size(), [&] { return uniform(state); });
  Eigen::VectorXd moved;
  problem.delassus.apply(xi, moved);
  changed.free_velocity += size * norm(problem.free_velocity) / norm(moved) * moved;
  for (auto& law : changed.law)
    if constexpr (requires { law.friction = 0; }) law.friction *= 1 + 0.3 * uniform(state);
  return changed;
}

}  // namespace

int main(int argc, char** argv) {
  constexpr double time_limit = 10, slow = 1;  // seconds
  CsvWriter csv("fclib_families.csv",
                {"problem", "variant", "size", "contacts", "converged", "sweeps", "seconds",
                 "scaled_residual", "residual", "compiler", "flags", "commit"});
  Index n_variants = 9, n_problems = 0, n_solved = 0;
  Array<std::string> files;
  for (int i = 1; i < argc; ++i)
    if (std::string(argv[i]) == "--variants" && i + 1 < argc)
      n_variants = std::atoi(argv[++i]);
    else
      files.push_back(argv[i]);
  double longest = 0;
  for (const std::string& file : files) {
    const std::string name = std::filesystem::path(file).stem().string();
    std::uint64_t state = 1;
    std::visit(
        [&](const auto& problem) {
          for (Index k = 0; k < n_variants; ++k) {
            const double size = k % 3 == 0 ? 0.003 : k % 3 == 1 ? 0.1 : 1;
            const auto changed = variant(problem, size, state);
            Eigen::VectorXd r = Eigen::VectorXd::Zero(changed.free_velocity.size()), u;
            const StoppingCriterion stop{.time_limit = time_limit, .strict = true};
            const double start = jampack_bench::cpu_seconds();
            const SolveReport report = DefaultSolver{.stop = stop}.solve(changed, r);
            const double seconds = jampack_bench::cpu_seconds() - start;
            contact_velocity(changed, r, u);
            ++n_problems;
            n_solved += report.converged ? 1 : 0;
            longest = std::max(longest, seconds);
            csv.write({name, k, size, changed.n_contacts(), report.converged ? 1 : 0, report.sweeps, seconds,
                       report.residual, residual(changed, r, u), jampack_bench::compiler(),
                       jampack_bench::flags(), jampack_bench::commit()});
            if (!report.converged || seconds > slow)
              std::printf("%-36s variant %2td (%g): %s in %.2f s, scaled residual %.1e\n", name.c_str(), k,
                          size, report.converged ? "solved" : "not solved", seconds, report.residual);
          }
        },
        read_fclib(file));
  }
  std::printf("%td of %td solved, the longest in %.2f s\n", n_solved, n_problems, longest);
}
#else
int main() {
  std::cerr << "fclib_families: built without HDF5\n";
  return 2;
}
#endif
