// SPDX-License-Identifier: MIT
// Sweeps and CPU time to 1e-4, 1e-6 and 1e-8 against the number of balls, in packings pressed by
// stress-driven walls, with friction 0.3 and without. Prints a table, writes solver_growth.csv.
//   solver_growth [LARGEST [SMALLEST]]     10^2, 10^2.5, ... LARGEST balls (default 10000)
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <jampack/io/csv_writer.hpp>
#include <jampack/solver/default_solver.hpp>
#include <set>
#include <string>

#include "../tests/solver/ball_packing.hpp"
#include "measure.hpp"

using namespace jampack;
using jampack_bench::cpu_seconds;

namespace {

constexpr double time_limit = 30;  // seconds for one solution

template <int N>
void measure(Index n_balls, CsvWriter& csv) {
  const auto problem = jampack_tests::pressed_packing<3, N>(n_balls, 0.65, 0.3);
  std::set<std::string> out_of_time;  // is not tried at smaller tolerances
  for (const double tolerance : {1e-4, 1e-6, 1e-8}) {
    const StoppingCriterion stop{.tolerance = tolerance, .max_sweeps = 10000000, .time_limit = time_limit};
    const auto run = [&](const std::string& name, const auto& solver) {
      if (out_of_time.contains(name)) return;
      Eigen::VectorXd r = Eigen::VectorXd::Zero(problem.free_velocity.size());
      const double start = cpu_seconds();
      const SolveReport report = solver.solve(problem, r);
      const double seconds = cpu_seconds() - start;
      if (!report.converged) out_of_time.insert(name);
      std::printf("%8td %9td %8s %6.0e %-16s %5s %9td %10.3f s  residual %.1e\n", n_balls,
                  problem.n_contacts(), N == 1 ? "none" : "0.3", tolerance, name.c_str(),
                  report.converged ? "yes" : "no", report.sweeps, seconds, report.residual);
      std::fflush(stdout);
      csv.write({n_balls, problem.n_contacts(), N == 1 ? 0.0 : 0.3, tolerance, name, report.converged ? 1 : 0,
                 report.sweeps, seconds, report.residual, jampack_bench::compiler(), jampack_bench::flags(),
                 jampack_bench::commit()});
    };
    run("sweeps", GaussSeidel{.stop = stop});
    run("sweeps_relaxed", GaussSeidel{.stop = stop, .relaxation = 1.6});
    run("default", DefaultSolver{.stop = stop});
    if (n_balls > 4000) continue;
    run("sweeps_coloured", GaussSeidel{stop, SweepOrder::coloured});
    run("proximal_newton", ProximalNewton{.stop = stop});  // for more balls, factors take minutes
  }
}

}  // namespace

int main(int argc, char** argv) {
  const double largest = argc > 1 ? std::atof(argv[1]) : 1e4;
  CsvWriter csv("solver_growth.csv", {"balls", "contacts", "friction", "tolerance", "solver", "converged",
                                      "sweeps", "seconds", "scaled_residual", "compiler", "flags", "commit"});
  std::printf("%8s %9s %8s %6s %-16s %5s %9s\n", "balls", "contacts", "friction", "to", "solver", "done",
              "sweeps");
  for (double n = argc > 2 ? std::atof(argv[2]) : 100; n <= 1.01 * largest; n *= std::sqrt(10.0)) {
    const auto n_balls = static_cast<Index>(std::lround(n));
    measure<3>(n_balls, csv);
    measure<1>(n_balls, csv);
  }
}
