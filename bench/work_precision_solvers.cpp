// SPDX-License-Identifier: MIT
// Residual against CPU time, every solver on every problem, from a zero first guess and, where the file has
// one, from its guess, set-up counted.
//   work_precision_solvers FILE ...   text format (or FCLIB .hdf5): work_precision_solvers.csv and, where
//                                     gnuplot is, one picture a problem
//   work_precision_solvers            the hard problems with known answers: hard_problems.csv, a table
//                                     solver x case with the error against the answer
#include <cstdio>
#include <filesystem>
#include <functional>
#include <jampack/io/contact_problem_text.hpp>
#include <jampack/io/csv_writer.hpp>
#include <string>
#include <variant>
#ifdef JAMPACK_WITH_HDF5
#include <jampack/io/fclib.hpp>
#endif

#include "../tests/solver/hard_problems.hpp"
#include "solver_curves.hpp"

using namespace jampack;
using namespace jampack_bench;
using namespace jampack_tests;

namespace {

constexpr double time_limit = 3;  // seconds for one solution

ContactProblemFile read(const std::filesystem::path& path) {
  if (path.extension() != ".hdf5" && path.extension() != ".h5") return read_contact_problem(path);
#ifdef JAMPACK_WITH_HDF5
  return {read_fclib(path), {}};
#else
  throw InvalidInput(path.string() + ": built without HDF5");
#endif
}

// ---- problems from files ----------------------------------------------------------------------------

void measure_file(const std::filesystem::path& path, SolverCurves& curves) {
  const std::string name = path.stem().string();
  const ContactProblemFile file = read(path);
  std::visit(
      [&](const auto& problem) {
        curves.measure(name, problem, Eigen::VectorXd::Zero(problem.free_velocity.size()));
        if (file.guess.size() > 0) curves.measure(name + "_warm", problem, file.guess);
      },
      file.problem);
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
      const SolveReport report = run_solver(solver, tolerance, time_limit, problem, r);
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
  SolverCurves curves("work_precision_solvers.csv", time_limit);
  for (int k = 1; k < argc; ++k) measure_file(argv[k], curves);
}
