// SPDX-License-Identifier: MIT
// Side by side with Siconos in one process: the same problems in memory, the same clock, set-up counted, both
// timed to the same scaled_residual. Siconos at the loosest of its own tolerances that reaches it.
//   peer_siconos [--variants NAME,...] FILE.hdf5 ...    writes peer_siconos.csv
//   peer_siconos --sweeps FILE.hdf5 ...                 one Gauss–Seidel sweep beside one of NSGS with NSN

#include <numerics/FrictionContactProblem.h>
#include <numerics/Friction_cst.h>
#include <numerics/NonSmoothDrivers.h>
#include <numerics/NumericsMatrix.h>
#include <numerics/NumericsVerbose.h>
#include <numerics/SolverOptions.h>
#include <numerics/SparseBlockMatrix.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <jampack/io/csv_writer.hpp>
#include <jampack/solver/default_solver.hpp>
#include <limits>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "measure.hpp"
#ifdef JAMPACK_WITH_HDF5
#include <jampack/io/fclib.hpp>
#endif

using namespace jampack;
using namespace jampack_bench;

#ifdef JAMPACK_WITH_HDF5
namespace {

using Problem = StoredContactProblem<3>;

constexpr double time_limit = 4;  // CPU seconds for one solver on one problem
constexpr double infinity = std::numeric_limits<double>::infinity();

// What Siconos is tried with: solver, local solver, how the error is tested, form of W.
struct Variant {
  const char* name;
  int solver;
  int local = 0;
  bool full_error = false;  // every 10 sweeps, not the cheap one
  bool sparse = false;      // W in compressed columns, not blocks
};
const Variant variants[] = {
    {"NSGS", SICONOS_FRICTION_3D_NSGS},
    {"NSGS-PLI", SICONOS_FRICTION_3D_NSGS, SICONOS_FRICTION_3D_ONECONTACT_ProjectionOnConeWithLocalIteration},
    {"NSGS-NSN", SICONOS_FRICTION_3D_NSGS, SICONOS_FRICTION_3D_ONECONTACT_NSN},
    {"NSGS-NSN-FE", SICONOS_FRICTION_3D_NSGS, SICONOS_FRICTION_3D_ONECONTACT_NSN, true},
    {"NSN_AC", SICONOS_FRICTION_3D_NSN_AC},
    {"NSN_FB", SICONOS_FRICTION_3D_NSN_FB},
    {"PROX", SICONOS_FRICTION_3D_PROX},
    {"ADMM", SICONOS_FRICTION_3D_ADMM, 0, false, true},
};

// Siconos wants W in its own sparse block format; making that is not timed.
struct Peer {
  SparseBlockStructuredMatrix blocks{};
  NumericsMatrix *w = NM_new(), *sparse = nullptr;
  std::vector<double> q, mu, values;
  std::vector<unsigned int> sizes;
  std::vector<double*> pointers;
  std::vector<std::size_t> row_start, column;
  FrictionContactProblem problem{};

  explicit Peer(const Problem& from) {
    const auto stored = stored_blocks(from.delassus);
    const auto n = static_cast<unsigned int>(from.n_contacts());
    values.reserve(9 * static_cast<std::size_t>(stored.size()));
    row_start.assign(n + 1, 0);
    for (const auto& block : stored) {
      pointers.push_back(values.data() + values.size());
      values.insert(values.end(), block.value.data(), block.value.data() + 9);
      column.push_back(static_cast<std::size_t>(block.column));
      row_start[static_cast<std::size_t>(block.row) + 1] = column.size();
    }
    for (unsigned int c = 0; c < n; ++c) {
      sizes.push_back(3 * (c + 1));
      mu.push_back(from.law[c].friction);
    }
    q.assign(from.free_velocity.data(), from.free_velocity.data() + from.free_velocity.size());
    blocks.nbblocks = static_cast<unsigned int>(stored.size());
    blocks.block = pointers.data();
    blocks.blocknumber0 = blocks.blocknumber1 = n;
    blocks.blocksize0 = blocks.blocksize1 = sizes.data();
    blocks.filled1 = n + 1;
    blocks.filled2 = column.size();
    blocks.index1_data = row_start.data();
    blocks.index2_data = column.data();
    w->storageType = NM_SPARSE_BLOCK;
    w->size0 = w->size1 = static_cast<int>(3 * n);
    w->matrix1 = &blocks;
    problem.dimension = 3;
    problem.numberOfContacts = static_cast<int>(n);
    problem.M = w;
    problem.q = q.data();
    problem.mu = mu.data();
  }

  // As many sweeps as are asked for, or as fit the time limit.
  void run(const Variant& variant, double own_tolerance, Eigen::VectorXd& r, Eigen::VectorXd& u,
           int max_sweeps = 0) {
    r.setZero(3 * problem.numberOfContacts);
    u.setZero(r.size());
    if (variant.sparse && sparse == nullptr) {
      sparse = NM_create(NM_SPARSE, w->size0, w->size1);
      NM_copy_to_sparse(w, sparse, 0);
    }
    problem.M = variant.sparse ? sparse : w;
    SolverOptions* const options = solver_options_create(variant.solver);
    if (variant.local != 0) solver_options_update_internal(options, 0, variant.local);
    options->dparam[SICONOS_DPARAM_TOL] = own_tolerance;
    const bool sweeps = variant.solver == SICONOS_FRICTION_3D_NSGS;
    options->iparam[SICONOS_IPARAM_MAX_ITER] = sweeps ? 1000000 : 10000;
    if (variant.full_error) {
      options->iparam[SICONOS_FRICTION_3D_IPARAM_ERROR_EVALUATION] =
          SICONOS_FRICTION_3D_NSGS_ERROR_EVALUATION_FULL;
      options->iparam[SICONOS_FRICTION_3D_IPARAM_ERROR_EVALUATION_FREQUENCY] = 10;
    }
    // A limit of sweeps that fits the time limit: Siconos has no clock.
    if (sweeps)
      options->iparam[SICONOS_IPARAM_MAX_ITER] = static_cast<int>(
          std::clamp(time_limit / (2e-9 * 9 * static_cast<double>(pointers.size())), 100.0, 1e7));
    if (max_sweeps > 0) options->iparam[SICONOS_IPARAM_MAX_ITER] = max_sweeps;
    fc3d_driver(&problem, r.data(), u.data(), options);
    solver_options_delete(options);
  }

  // CPU seconds of one solution at the loosest of its own tolerances that reaches the wanted scaled_residual;
  // infinity if none does.
  double solve(const Problem& from, const Variant& variant, double wanted) {
    Eigen::VectorXd r, u;
    const double start = cpu_seconds();
    for (double own = 1e-2; own >= 1e-14; own *= 0.1) {
      const double before = cpu_seconds();
      run(variant, own, r, u);
      const double once = cpu_seconds() - before;
      if (r.allFinite() && scaled_residual(from, r) <= wanted)
        return once >= 0.2 ? once : seconds_of([&] { run(variant, own, r, u); });
      if (once > time_limit || cpu_seconds() - start > 1.5 * time_limit) break;
    }
    return infinity;
  }
};

// CPU seconds of one sweep, by the difference of two numbers of them: set-up, the same in both, drops out.
template <class Run>
double seconds_a_sweep(const Run& run) {
  constexpr int few = 20, many = 120;
  double least = infinity;
  for (int k = 0; k < 5; ++k) {
    const double short_run = seconds_of([&] { run(few); }), long_run = seconds_of([&] { run(many); });
    least = std::min(least, (long_run - short_run) / (many - few));
  }
  return least;
}

void compare_sweeps(const std::string& name, const Problem& problem) {
  Peer peer(problem);
  const Variant newton = {"", SICONOS_FRICTION_3D_NSGS, SICONOS_FRICTION_3D_ONECONTACT_NSN};
  Eigen::VectorXd peer_r, peer_u;
  const double theirs = seconds_a_sweep([&](int n) { peer.run(newton, 1e-300, peer_r, peer_u, n); });
  const double ours = seconds_a_sweep([&](int n) {
    Eigen::VectorXd r = Eigen::VectorXd::Zero(problem.free_velocity.size());
    GaussSeidelSweeps sweeps(problem, r);
    for (int k = 0; k < n; ++k) sweeps.sweep(r);
  });
  std::printf("%-36s %5td contacts, W %6.0f kB: %8.2f us a sweep, Siconos %8.2f, ratio %.1f\n", name.c_str(),
              problem.n_contacts(), 8e-3 * static_cast<double>(problem.delassus.n_stored()), 1e6 * ours,
              1e6 * theirs, theirs / ours);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1 && std::string(argv[1]) == "--sweeps") {
    numerics_set_verbose(0);
    for (int k = 2; k < argc; ++k) {
      const AnyContactProblem any = read_fclib(argv[k]);
      if (const Problem* const problem = std::get_if<Problem>(&any))
        compare_sweeps(std::filesystem::path(argv[k]).stem().string(), *problem);
    }
    return 0;
  }
  if (argc < 2) {
    std::puts(
        "peer_siconos FILE.hdf5 ...   the default solver beside those of Siconos, one process, CPU time");
    return 2;
  }
  // Siconos can end the process for good: then those of its variants that do not.
  const bool selects = argc > 3 && std::string(argv[1]) == "--variants";
  const std::string selected = selects ? argv[2] : "";
  Array<std::string> columns = {"problem", "contacts", "tolerance", "default"};
  for (const Variant& variant : variants) columns.push_back(variant.name);
  for (const char* column : {"compiler", "flags", "commit"}) columns.push_back(column);
  CsvWriter csv("peer_siconos.csv", columns);
  numerics_set_verbose(0);
  std::printf("CPU milliseconds\n%-22s %8s %6s %9s", "problem", "contacts", "to", "default");
  for (const Variant& variant : variants) std::printf(" %11s", variant.name);
  std::printf(" %9s %9s\n", "best/us", "PROX/us");
  struct Mean {
    double logarithm = 0;
    int n = 0;
    void add(double ratio) {
      logarithm += std::log(ratio);
      ++n;
    }
    double value() const { return n > 0 ? std::exp(logarithm / n) : std::nan(""); }
  };
  Mean best_mean[2][2], proximal_mean[2][2];  // by tolerance; problems of 1 ms and more, and below
  for (int k = selects ? 3 : 1; k < argc; ++k) {
    const AnyContactProblem any = read_fclib(argv[k]);
    const Problem* const problem = std::get_if<Problem>(&any);
    if (problem == nullptr) continue;
    Peer peer(*problem);
    for (const int fine : {0, 1}) {
      const double tolerance = fine == 1 ? 1e-8 : 1e-3;
      bool solved = false;
      double ours = seconds_of([&] {
        Eigen::VectorXd r = Eigen::VectorXd::Zero(problem->free_velocity.size());
        solved = DefaultSolver{.stop = {.tolerance = tolerance, .time_limit = time_limit}}
                     .solve(*problem, r)
                     .converged;
      });
      if (!solved) ours = time_limit;
      const std::string name = std::filesystem::path(argv[k]).stem().string();
      Array<CsvCell> row = {name, problem->n_contacts(), tolerance, solved ? ours : std::nan("")};
      std::printf("%-22.22s %8td %6.0e %9.3f", name.c_str(), problem->n_contacts(), tolerance, 1e3 * ours);
      double best = time_limit, proximal = time_limit;  // a failure counts as the time limit
      for (const Variant& variant : variants) {
        const double seconds =
            named(selected, variant.name) ? peer.solve(*problem, variant, tolerance) : infinity;
        best = std::min(best, seconds);
        if (variant.solver == SICONOS_FRICTION_3D_PROX) proximal = std::min(seconds, time_limit);
        row.push_back(std::isfinite(seconds) ? seconds : std::nan(""));
        std::printf(" %11.3f", 1e3 * seconds);
        std::fflush(stdout);
      }
      const int small = ours < 1e-3 ? 1 : 0;
      best_mean[fine][small].add(best / ours);
      proximal_mean[fine][small].add(proximal / ours);
      std::printf(" %9.2f %9.2f\n", best / ours, proximal / ours);
      for (const std::string& text : {compiler(), flags(), commit()}) row.push_back(text);
      csv.write(std::span(row.data(), static_cast<std::size_t>(row.size())));
    }
  }
  for (const int fine : {0, 1})
    for (const int small : {0, 1})
      std::printf("to %s, %s: geometric mean of best/us %.2f, of PROX/us %.2f (%d problems)\n",
                  fine == 1 ? "1e-8" : "1e-3", small == 1 ? "below 1 ms" : "1 ms and more",
                  best_mean[fine][small].value(), proximal_mean[fine][small].value(),
                  best_mean[fine][small].n);
}
#else
int main() {
  std::puts("peer_siconos: built without HDF5, from which it reads its problems");
  return 2;
}
#endif
