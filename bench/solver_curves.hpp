// SPDX-License-Identifier: MIT
#pragma once

// Residual against CPU time of every solver on one contact problem: what work_precision_solvers does with
// problems from files and soft_contact_problems with those of stored packings.
#include <cmath>
#include <cstdio>
#include <jampack/io/csv_writer.hpp>
#include <jampack/io/curve_picture.hpp>
#include <jampack/solver/admm.hpp>
#include <jampack/solver/default_solver.hpp>
#include <string>

#include "measure.hpp"

namespace jampack_bench {

inline const jampack::Array<std::string> solver_names = {
    "default", "sweeps", "sweeps_symmetric", "sweeps_shuffled", "sweeps_coloured", "proximal_newton", "admm"};

template <class Problem>
jampack::SolveReport run_solver(const std::string& name, double tolerance, double time_limit,
                                const Problem& problem, Eigen::VectorXd& r) {
  using namespace jampack;
  const StoppingCriterion stop{.tolerance = tolerance, .max_sweeps = 10000000, .time_limit = time_limit};
  if (name == "sweeps") return GaussSeidel{.stop = stop}.solve(problem, r);
  if (name == "sweeps_symmetric") return GaussSeidel{stop, SweepOrder::symmetric}.solve(problem, r);
  if (name == "sweeps_shuffled") return GaussSeidel{stop, SweepOrder::shuffled}.solve(problem, r);
  if (name == "sweeps_coloured") return GaussSeidel{stop, SweepOrder::coloured}.solve(problem, r);
  if (name == "proximal_newton") return ProximalNewton{.stop = stop}.solve(problem, r);
  // As a step of deformable grains calls it.
  if (name == "proximal_newton_soft")
    return ProximalNewton{.stop = stop, .regularisation = 0.1}.solve(problem, r);
  if constexpr (!Problem::LocalLaw::is_compliant)
    if (name == "admm") return Admm{.stop = stop}.solve(problem, r);
  return DefaultSolver{.stop = stop}.solve(problem, r);
}

/// Curves of all solvers, one table of them and its pictures.
class SolverCurves {
 public:
  /// `time_limit`: seconds for one solution.
  SolverCurves(const std::string& file, double time_limit)
      : time_limit_(time_limit),
        csv_(file, {"problem", "contacts", "solver", "tolerance", "seconds", "scaled_residual", "sweeps",
                    "converged", "compiler", "flags", "commit"}) {}

  /// Every one of `solvers` on this problem, from `guess`, set-up counted.
  template <class Problem>
  void measure(const std::string& name, const Problem& problem, const Eigen::VectorXd& guess,
               const jampack::Array<std::string>& solvers = solver_names) {
    jampack::CurvePicture picture{"log10 of CPU seconds", "scaled_residual", {}, true};
    picture.key = "left bottom";  // residuals fall
    std::printf("%s: %td contacts; CPU milliseconds to 1e-2, 1e-4, 1e-6, 1e-8, 1e-10\n", name.c_str(),
                problem.n_contacts());
    for (const std::string& solver : solvers)
      if (const std::string file = name + "." + solver + ".csv";
          curve(file, name, solver, problem, guess) > 1)
        picture.curves.push_back({file, "log10_seconds", "scaled_residual", solver});
    if (!picture.curves.empty()) draw(picture, name + ".png");
  }

 private:
  /// The number of points written.
  template <class Problem>
  int curve(const std::string& file, const std::string& name, const std::string& solver,
            const Problem& problem, const Eigen::VectorXd& guess) {
    jampack::CsvWriter points(file, {"log10_seconds", "scaled_residual"});
    std::printf("  %-20s", solver.c_str());
    int n_points = 0;
    for (const double tolerance : {1e-2, 1e-4, 1e-6, 1e-8, 1e-10}) {
      jampack::SolveReport report;
      const double seconds = seconds_of(
          [&] {
            Eigen::VectorXd r = guess;
            report = run_solver(solver, tolerance, time_limit_, problem, r);
          },
          0.05);
      csv_.write({name, problem.n_contacts(), solver, tolerance, seconds, report.residual, report.sweeps,
                  report.converged ? 1 : 0, compiler(), flags(), commit()});
      if (report.residual > 0) {
        points.write({std::log10(seconds), report.residual});
        ++n_points;
      }
      if (report.converged)
        std::printf(" %9.3f", 1e3 * seconds);
      else
        std::printf("  (%.1e)", report.residual);
      std::fflush(stdout);
      if (!report.converged) break;
    }
    std::puts("");
    return n_points;
  }

  double time_limit_;
  jampack::CsvWriter csv_;
};

}  // namespace jampack_bench
