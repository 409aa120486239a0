// SPDX-License-Identifier: MIT
// Residual against CPU time, every solver on every problem, from a zero first guess, set-up counted.
//   work_precision_solvers FILE ...   text format (or FCLIB .hdf5): work_precision_solvers.csv and, where
//                                     gnuplot is, one picture a problem
//   work_precision_solvers            the hard problems with known answers: hard_problems.csv, a table
//                                     solver x case with the error against the answer
#include <cstdio>
#include <filesystem>
#include <functional>
#include <jampack/io/contact_problem_text.hpp>
#include <jampack/io/csv_writer.hpp>
#include <jampack/io/curve_picture.hpp>
#include <jampack/solver/admm.hpp>
#include <jampack/solver/default_solver.hpp>
#include <string>
#include <variant>
#ifdef JAMPACK_WITH_HDF5
#include <jampack/io/fclib.hpp>
#endif

#include "../tests/solver/hard_problems.hpp"
#include "measure.hpp"

using namespace jampack;
using namespace jampack_tests;
using jampack_bench::cpu_seconds;

namespace {

constexpr double time_limit = 3;  // seconds for one solution
const Array<std::string> solver_names = {
    "default", "sweeps", "sweeps_symmetric", "sweeps_shuffled", "sweeps_coloured", "proximal_newton", "admm"};

template <class Problem>
SolveReport run(const std::string& name, double tolerance, const Problem& problem, Eigen::VectorXd& r) {
  const StoppingCriterion stop{.tolerance = tolerance, .max_sweeps = 10000000, .time_limit = time_limit};
  if (name == "sweeps") return GaussSeidel{.stop = stop}.solve(problem, r);
  if (name == "sweeps_symmetric") return GaussSeidel{stop, SweepOrder::symmetric}.solve(problem, r);
  if (name == "sweeps_shuffled") return GaussSeidel{stop, SweepOrder::shuffled}.solve(problem, r);
  if (name == "sweeps_coloured") return GaussSeidel{stop, SweepOrder::coloured}.solve(problem, r);
  if (name == "proximal_newton") return ProximalNewton{.stop = stop}.solve(problem, r);
  if constexpr (!Problem::LocalLaw::is_compliant)
    if (name == "admm") return Admm{.stop = stop}.solve(problem, r);
  return DefaultSolver{.stop = stop}.solve(problem, r);
}

AnyContactProblem read(const std::filesystem::path& path) {
  if (path.extension() != ".hdf5" && path.extension() != ".h5") return read_contact_problem(path).problem;
#ifdef JAMPACK_WITH_HDF5
  return read_fclib(path);
#else
  throw InvalidInput(path.string() + ": built without HDF5");
#endif
}

// ---- problems from files ----------------------------------------------------------------------------

void measure_file(const std::filesystem::path& path, CsvWriter& csv) {
  const std::string name = path.stem().string();
  std::visit(
      [&](const auto& problem) {
        CurvePicture picture{"log10 of CPU seconds", "scaled_residual", {}, true};
        std::printf("%s: %td contacts; CPU milliseconds to 1e-2, 1e-4, 1e-6, 1e-8, 1e-10\n", name.c_str(),
                    problem.n_contacts());
        for (const std::string& solver : solver_names) {
          const std::string file = name + "." + solver + ".csv";
          CsvWriter curve(file, {"log10_seconds", "scaled_residual"});
          std::printf("  %-18s", solver.c_str());
          Index n_points = 0;
          for (const double tolerance : {1e-2, 1e-4, 1e-6, 1e-8, 1e-10}) {
            SolveReport report;
            const double seconds = jampack_bench::seconds_of(
                [&] {
                  Eigen::VectorXd r = Eigen::VectorXd::Zero(problem.free_velocity.size());
                  report = run(solver, tolerance, problem, r);
                },
                0.05);
            csv.write({name, problem.n_contacts(), solver, tolerance, seconds, report.residual, report.sweeps,
                       report.converged ? 1 : 0, jampack_bench::compiler(), jampack_bench::flags(),
                       jampack_bench::commit()});
            if (report.residual > 0) {
              curve.write({std::log10(seconds), report.residual});
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
          if (n_points > 1) picture.curves.push_back({file, "log10_seconds", "scaled_residual", solver});
        }
        if (!picture.curves.empty()) draw(picture, name + ".png");
      },
      read(path));
}

// ---- hard problems ----------------------------------------------------------------------------------

struct HardTable {
  CsvWriter csv{"hard_problems.csv",
                {"case", "solver", "solved", "error", "seconds", "sweeps", "scaled_residual"}};

  // `error` judges r and u against the known answer; a case that has none wants no convergence.
  template <class Problem, class Error>
  void add(const std::string& name, const Problem& problem, Error error, bool feasible = true,
           const Eigen::VectorXd& guess = {}, double tolerance = 1e-10) {
    std::printf("%-34s", name.c_str());
    for (const std::string& solver : solver_names) {
      Eigen::VectorXd r = guess, u(problem.free_velocity.size());
      if (r.size() == 0) r.setZero(problem.free_velocity.size());
      const double start = cpu_seconds();
      const SolveReport report = run(solver, tolerance, problem, r);
      const double seconds = cpu_seconds() - start;
      contact_velocity(problem, r, u);
      const double wrong = error(r, u);
      csv.write({name, solver, report.converged ? 1 : 0, wrong, seconds, report.sweeps, report.residual});
      const bool as_wanted = report.converged == feasible && r.allFinite();
      std::printf(" | %s %7.0e %8.2f", as_wanted ? "yes" : " no", wrong, 1e3 * seconds);
      std::fflush(stdout);
    }
    std::puts("");
  }
};

double relative(const Vector<3>& found, const Vector<3>& wanted) {
  return (found - wanted).norm() / wanted.norm();
}

void measure_hard_problems() {
  std::printf("%-34s", "as wanted, error, CPU ms");
  for (const std::string& solver : solver_names) std::printf(" | %-20s", solver.c_str());
  std::puts("");
  HardTable table;
  const auto equal_forces = [](double wanted) {
    return [wanted](const Eigen::VectorXd& r, const Eigen::VectorXd&) {
      double worst = 0;
      const Index n = r.size() % 3 == 0 && r[1] == 0 && r[2] == 0 ? 3 : 1;
      for (Index c = 0; c < r.size(); c += n) worst = std::max(worst, std::abs(r[c] / wanted - 1));
      return worst;
    };
  };
  for (const Index n : {10, 100, 1000})
    table.add("chain of " + std::to_string(n), chain<3>(n, 2.0), equal_forces(2.0));
  table.add("chain of 20, last one 1e6 heavier", chain<1>(20, 2e6, 1e6), equal_forces(2e6), true, {}, 1e-13);
  const auto landing = [](double slide, double friction) {
    return [=](const Eigen::VectorXd& r, const Eigen::VectorXd&) {
      return relative(total(r), Vector<3>(1, -std::min(slide, friction), 0));
    };
  };
  for (const int n : {2, 4, 10}) {
    table.add("block on " + std::to_string(n * n) + " points, sticks", block_on_floor(n, 0.2, 0.5),
              landing(0.2, 0.5));
    table.add("block on " + std::to_string(n * n) + " points, slides", block_on_floor(n, 0.7, 0.5),
              landing(0.7, 0.5));
  }
  table.add("every contact ten times", block_on_floor(2, 0.2, 0.5, 10), landing(0.2, 0.5));
  for (const double friction : {0.0, 0.01, 0.3, 1.0, 10.0})
    for (const double factor : {1 - 1e-6, 1 + 1e-6}) {
      char name[64];
      std::snprintf(name, sizeof name, "mu = %g, slide at mu (1 %c 1e-6)", friction, factor < 1 ? '-' : '+');
      table.add(name, point_on_floor(friction * factor, friction),
                [&](const Eigen::VectorXd&, const Eigen::VectorXd& u) {
                  return std::abs(u.tail<2>().norm() - std::max(0.0, friction * (factor - 1)));
                });
    }
  for (const double factor : {0.99, 1.01}) {
    Eigen::VectorXd prestress;
    const auto problem = wedge(0.3, std::tan(0.3) * factor, prestress);
    table.add(
        factor < 1 ? "wedge below atan mu: leaves" : "wedge above atan mu: locked", problem,
        [=](const Eigen::VectorXd&, const Eigen::VectorXd& u) {
          return factor > 1 ? u.norm() : std::abs(u.norm() - std::sqrt(2.0));
        },
        true, prestress);
  }
  for (const double unit : {1e-9, 1e9})
    table.add("units: mass " + std::to_string(unit < 1 ? -9 : 9) + " decades, length opposite",
              block_on_floor(3, 0.7, 0.5, 1, unit, 1 / unit, unit),
              [=](const Eigen::VectorXd& r, const Eigen::VectorXd&) {
                return relative(total(r) * unit, Vector<3>(1, -0.5, 0));
              });
  table.add(
      "infeasible: squeezed ball", squeezed_ball(),
      [](const Eigen::VectorXd& r, const Eigen::VectorXd&) { return r.allFinite() ? 0.0 : 1.0; }, false);
  const auto none = [](const Eigen::VectorXd& r, const Eigen::VectorXd&) { return r.norm(); };
  table.add("no contact", ContactProblem(BlockSparseDelassus<3>(0, {}), Eigen::VectorXd(), {}), none);
  table.add("zero block, opening",
            ContactProblem(BlockSparseDelassus<3>(1, {}), vector_of({1, 2, 3}), {{0.5}}), none);
  table.add("zero block, closing (infeasible)",
            ContactProblem(BlockSparseDelassus<3>(1, {}), vector_of({-1, 0, 0}), {{0.5}}), none, false);
  bool refused = false;
  try {
    const ContactProblem problem(BlockSparseDelassus<3>(1, {}), vector_of({std::nan(""), 0, 0}), {{0.5}});
  } catch (const InvalidInput&) {
    refused = true;
  }
  std::printf("NaN in q is refused: %s\n", refused ? "yes" : "no");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    measure_hard_problems();
    return 0;
  }
  CsvWriter csv("work_precision_solvers.csv",
                {"problem", "contacts", "solver", "tolerance", "seconds", "scaled_residual", "sweeps",
                 "converged", "compiler", "flags", "commit"});
  for (int k = 1; k < argc; ++k) measure_file(argv[k], csv);
}
