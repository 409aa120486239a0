// SPDX-License-Identifier: MIT
// Solves one contact problem from a file: the text format of io/contact_problem_text.hpp, or FCLIB's HDF5
// files where the program was built with HDF5. Prints one line and writes reactions.csv and velocities.csv.
#include <array>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <jampack/io/command_line.hpp>
#include <jampack/io/contact_problem_text.hpp>
#include <jampack/io/json.hpp>
#include <jampack/io/run_program.hpp>
#include <jampack/solver/admm.hpp>
#include <jampack/solver/default_solver.hpp>
#include <limits>
#include <string>
#include <string_view>
#include <variant>
#ifdef JAMPACK_WITH_HDF5
#include <jampack/io/fclib.hpp>
#endif

using namespace jampack;

namespace {

const Array<std::string> solver_names = {
    "default", "gauss_seidel", "gauss_seidel_symmetric", "gauss_seidel_shuffled", "proximal_newton", "admm"};

template <class Problem>
SolveReport solve_with(const std::string& name, const StoppingCriterion& stop, const Problem& problem,
                       Eigen::VectorXd& r) {
  if (name == "gauss_seidel") return GaussSeidel{.stop = stop}.solve(problem, r);
  if (name == "gauss_seidel_symmetric") return GaussSeidel{stop, SweepOrder::symmetric}.solve(problem, r);
  if (name == "gauss_seidel_shuffled") return GaussSeidel{stop, SweepOrder::shuffled}.solve(problem, r);
  if (name == "proximal_newton") return ProximalNewton{.stop = stop}.solve(problem, r);
  if (name == "admm") {
    if constexpr (!Problem::LocalLaw::is_compliant) return Admm{.stop = stop}.solve(problem, r);
    throw InvalidInput("--solver admm does not solve compliant contacts");
  }
  return DefaultSolver{.stop = stop}.solve(problem, r);
}

ContactProblemFile read(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension != ".hdf5" && extension != ".h5") return read_contact_problem(path);
#ifdef JAMPACK_WITH_HDF5
  return {read_fclib(path), {}};
#else
  throw InvalidInput(path.string() + ": this program was built without HDF5 and reads the text format only");
#endif
}

// One contact a row; 17 digits, so that the numbers read back as they were.
void write_vectors(const std::filesystem::path& path, const char* quantity, const Eigen::VectorXd& values,
                   int n) {
  constexpr std::array axes = {"N", "T1", "T2"};
  std::string text;
  for (int i = 0; i < n; ++i)
    text += (i > 0 ? "," : "") + std::string(quantity) + "_" +
            (n == 2 && i == 1 ? "T" : axes[static_cast<std::size_t>(i)]);
  text += "\n";
  std::array<char, 32> number;
  for (Index k = 0; k < values.size(); ++k) {
    std::snprintf(number.data(), number.size(), "%.17g", values[k]);
    text += std::string(number.data()) + (k % n == n - 1 ? "\n" : ",");
  }
  write_file(path, text);
}

int solve_contact_problem(CommandLine& line) {
  std::string file, solver = "default", out = ".";
  double tolerance = 1e-8, time_limit = 60;
  Index max_sweeps = 100000000;
  bool list = false;
  line.argument("FILE", file, "the problem: text format, or FCLIB .hdf5");
  line.option("solver", solver, solver_names, "how to solve it");
  line.option("tolerance", tolerance, OptionRange{.lower = 0, .upper = 1, .upper_included = true},
              "on scaled_residual, also relative to |r| alone, and on residual");
  line.option("time-limit", time_limit, OptionRange{.lower = 0}, "seconds, after which the best is returned");
  line.option("max-sweeps", max_sweeps, OptionRange{.lower = 0}, "sweeps or iterations, likewise");
  line.option("out", out, "folder for reactions.csv, velocities.csv and summary.json");
  line.flag("list", list, "names the solvers");
  if (!line.parse()) return 0;
  make_output_folder(out);
  const ContactProblemFile input = read(file);
  return std::visit(
      [&](const auto& problem) {
        using Problem = std::remove_cvref_t<decltype(problem)>;
        Eigen::VectorXd r = input.guess, u(problem.free_velocity.size());
        if (r.size() == 0) r.setZero(problem.free_velocity.size());
        const StoppingCriterion stop{tolerance, max_sweeps, time_limit, true};
        const SolveReport report = solve_with(solver, stop, problem, r);
        contact_velocity(problem, r, u);
        const double other = residual(problem, r, u);
        std::printf(
            "converged=%d solver=%s contacts=%td sweeps=%td scaled_residual=%.3e residual=%.3e "
            "seconds=%.6f\n",
            report.converged ? 1 : 0, solver.c_str(), problem.n_contacts(), report.sweeps, report.residual,
            other, report.seconds);
        const std::filesystem::path folder = out;
        write_vectors(folder / "reactions.csv", "r", r, Problem::n_unknowns);
        write_vectors(folder / "velocities.csv", "u", u, Problem::n_unknowns);
        Json summary = Json::object();
        summary["parameters"] = line.parameters();
        summary["converged"] = Json(report.converged);
        summary["contacts"] = Json(problem.n_contacts());
        summary["sweeps"] = Json(report.sweeps);
        summary["scaled_residual"] = Json(report.residual);
        summary["residual"] = Json(other);
        summary["seconds"] = Json(report.seconds);
        write_file(folder / "summary.json", summary.text());
        return report.converged ? 0 : 1;
      },
      input.problem);
}

}  // namespace

int main(int argc, char** argv) {
  // --list needs no file.
  for (int i = 1; i < argc; ++i)
    if (std::string_view(argv[i]) == "--list") {
      for (const std::string& name : solver_names) std::cout << name << "\n";
      return 0;
    }
  return run_program(argc, argv, "solves one contact problem", solve_contact_problem);
}
