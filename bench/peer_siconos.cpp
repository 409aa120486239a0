// SPDX-License-Identifier: MIT
// Side by side with Siconos in one process: the same problems in memory, the same clock, set-up counted, both
// timed to the same scaled_residual. Siconos at the loosest of its own tolerances that reaches it.
//   peer_siconos FILE.hdf5 ...     writes peer_siconos.csv

#include <numerics/FrictionContactProblem.h>
#include <numerics/Friction_cst.h>
#include <numerics/NonSmoothDrivers.h>
#include <numerics/NumericsMatrix.h>
#include <numerics/NumericsVerbose.h>
#include <numerics/SolverOptions.h>
#include <numerics/SparseBlockMatrix.h>

#include <cstdio>
#include <filesystem>
#include <jampack/solver/default_solver.hpp>
#include <limits>
#include <string>
#include <variant>
#include <vector>
#ifdef JAMPACK_WITH_HDF5
#include <jampack/io/fclib.hpp>
#endif

using namespace jampack;

#ifdef JAMPACK_WITH_HDF5
namespace {

using Problem = StoredContactProblem<3>;

// Repeats until 0.2 s have passed; seconds of one run.
template <class Work>
double seconds_of(Work&& work) {
  const Stopwatch clock;
  int n = 0;
  do {
    work();
    ++n;
  } while (clock.seconds() < 0.2);
  return clock.seconds() / n;
}

// Siconos wants W in its own sparse block format; making that is not timed.
struct Peer {
  SparseBlockStructuredMatrix blocks{};
  NumericsMatrix* w = NM_new();
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

  // Seconds of one solution, or infinity if it does not reach the wanted scaled_residual.
  double solve(const Problem& from, int method, double wanted, double time_limit) {
    for (double own = 1e-3; own >= 1e-13; own *= 0.1) {
      Eigen::VectorXd r, u;
      const Stopwatch all;
      const double seconds = seconds_of([&] {
        r.setZero(from.free_velocity.size());
        u.setZero(from.free_velocity.size());
        SolverOptions* options = solver_options_create(method);
        options->dparam[SICONOS_DPARAM_TOL] = own;
        options->iparam[SICONOS_IPARAM_MAX_ITER] = method == SICONOS_FRICTION_3D_NSGS ? 20000 : 2000;
        fc3d_driver(&problem, r.data(), u.data(), options);
        solver_options_delete(options);
      });
      if (scaled_residual(from, r) <= wanted) return seconds;
      if (all.seconds() > time_limit) break;
    }
    return std::numeric_limits<double>::infinity();
  }
};

}  // namespace

int main(int argc, char** argv) {
  std::FILE* const csv = std::fopen("peer_siconos.csv", "w");
  if (csv == nullptr) return 2;
  numerics_set_verbose(0);
  std::fprintf(csv, "problem,contacts,tolerance,default_seconds,nsgs_seconds,nsn_ac_seconds,prox_seconds\n");
  std::printf("%-30s %8s %7s %12s %12s %12s %12s\n", "problem", "contacts", "to", "default", "NSGS", "NSN_AC",
              "PROX");
  for (int k = 1; k < argc; ++k) {
    const AnyContactProblem any = read_fclib(argv[k]);
    const Problem* const problem = std::get_if<Problem>(&any);
    if (problem == nullptr) continue;
    Peer peer(*problem);
    for (const double tolerance : {1e-3, 1e-8}) {
      bool solved = false;
      double ours = seconds_of([&] {
        Eigen::VectorXd r = Eigen::VectorXd::Zero(problem->free_velocity.size());
        solved =
            DefaultSolver{.stop = {.tolerance = tolerance, .time_limit = 10}}.solve(*problem, r).converged;
      });
      if (!solved) ours = std::numeric_limits<double>::infinity();
      const double nsgs = peer.solve(*problem, SICONOS_FRICTION_3D_NSGS, tolerance, 3);
      const double newton = peer.solve(*problem, SICONOS_FRICTION_3D_NSN_AC, tolerance, 3);
      const double proximal = peer.solve(*problem, SICONOS_FRICTION_3D_PROX, tolerance, 3);
      const std::string name = std::filesystem::path(argv[k]).stem().string();
      std::printf("%-30.30s %8td %7.0e %12.3e %12.3e %12.3e %12.3e\n", name.c_str(), problem->n_contacts(),
                  tolerance, ours, nsgs, newton, proximal);
      std::fprintf(csv, "%s,%td,%g,%.6e,%.6e,%.6e,%.6e\n", name.c_str(), problem->n_contacts(), tolerance,
                   ours, nsgs, newton, proximal);
      std::fflush(stdout);
    }
  }
  std::fclose(csv);
}
#else
int main() {
  std::puts("peer_siconos: built without HDF5, from which it reads its problems");
  return 2;
}
#endif
