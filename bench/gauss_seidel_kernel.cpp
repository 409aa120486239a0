// SPDX-License-Identifier: MIT
// Time of one contact update in a Gauss–Seidel sweep, for every form of the Delassus operator, beside the
// three ceilings of the machine measured in the same run: read bandwidth for what an update must read,
// multiply–add rate, and the chain of dependent operations: the local solution ("local") and, in stored W,
// where every contact is coupled with the one before, that solution handed on and multiplied by one block
// ("chain"); beside it that chain where the processor cannot foresee the contacts' states ("unforeseen").
// Then what two threads can gain here at most. Prints a table, writes gauss_seidel_kernel.csv.
//   gauss_seidel_kernel [Catch2 options]
#define CATCH_CONFIG_RUNNER
#include <cstdio>
#include <jampack/io/csv_writer.hpp>
#include <jampack/problem/grain_compliance_delassus.hpp>
#include <jampack/solver/gauss_seidel.hpp>
#include <map>
#include <memory>
#include <numeric>
#include <random>
#include <string>

#include "../tests/catch.hpp"
#include "../tests/solver/ball_packing.hpp"
#include "measure.hpp"

using namespace jampack;

namespace {

// What a benchmark's time is to be divided by and compared with.
struct Case {
  std::string form;
  int dim = 0, unknowns = 0, threads = 1;
  Index contacts = 0;
  double scalars = 0;                           // of W, read a contact
  double other_bytes = 0;                       // read a contact besides those
  double flops = 0;                             // a contact, a multiply-add counting two
  double local = 0, chain = 0, unforeseen = 0;  // seconds
  double bytes() const { return (8 * scalars + other_bytes) * static_cast<double>(contacts); }
};
std::map<std::string, Case> cases;
std::map<std::string, double> shortest;  // seconds a run, least of all samples

#if __has_include(<catch2/catch_all.hpp>)
using ListenerBase = Catch::EventListenerBase;
#else
using ListenerBase = Catch::TestEventListenerBase;
#endif

// The least sample is what the machine can do; the mean is what others on it left.
struct Recorder : ListenerBase {
  using ListenerBase::ListenerBase;
#if __has_include(<catch2/catch_all.hpp>)
  void benchmarkEnded(const Catch::BenchmarkStats<>& stats) override{
#else
  void benchmarkEnded(const Catch::BenchmarkStats<>& stats) override {
#endif
      double least = 1e300;
  for (const auto& sample : stats.samples)
    least = std::min(least, std::chrono::duration<double>(sample).count());
  shortest[stats.info.name] = least;
}
};  // namespace
CATCH_REGISTER_LISTENER(Recorder)

// Seconds a byte of reading a working set again and again: whole cache lines, four sums (no array of them,
// which would lie in memory).
double read_cost(double bytes) {
  struct alignas(64) Line {
    EightLanes values;
  };
  const Index n = std::max<Index>(4, static_cast<Index>(bytes / 256) * 4);
  const std::unique_ptr<Line[]> data(new Line[static_cast<std::size_t>(n)]());
  double least = 1e300;
  volatile double sink = 0;
  for (int k = 0; k < 7; ++k) {
    const Index times = std::max<Index>(1, 1000000 / n);
    const double start = jampack_bench::cpu_seconds();
    for (Index i = 0; i < times; ++i) {
      EightLanes a = {}, b = {}, c = {}, d = {};
      for (const Line* line = data.get(); line != data.get() + n; line += 4) {
        a += line[0].values;
        b += line[1].values;
        c += line[2].values;
        d += line[3].values;
      }
      const EightLanes all = (a + b) + (c + d);
      sink = sink + all[0] + all[7];
    }
    least = std::min(least, (jampack_bench::cpu_seconds() - start) /
                                (64 * static_cast<double>(n) * static_cast<double>(times)));
  }
  return least;
}

// Seconds a floating-point operation: chains of multiply-adds, as many as are in flight at once. Wide vectors
// or narrow ones, whichever the compiler makes faster code of.
template <class Lanes>
double flop_cost_in() {
  constexpr int n_lanes = sizeof(Lanes) / sizeof(double);
  double least = 1e300;
  volatile double sink = 0;
  for (int k = 0; k < 5; ++k) {
    Lanes a, b, c, d, e, f, g, h, factor, term;
    for (int i = 0; i < n_lanes; ++i) factor[i] = 0.999 + 1e-4 * sink, term[i] = 1e-3;
    a = b = c = d = e = f = g = h = term;
    constexpr Index times = 2000000;
    const double start = jampack_bench::cpu_seconds();
    for (Index i = 0; i < times; ++i) {
      a = a * factor + term, b = b * factor + term, c = c * factor + term, d = d * factor + term;
      e = e * factor + term, f = f * factor + term, g = g * factor + term, h = h * factor + term;
    }
    least = std::min(least, (jampack_bench::cpu_seconds() - start) / (8 * 2.0 * n_lanes * times));
    sink = sink + ((a + b) + (c + d) + ((e + f) + (g + h)))[0];
  }
  return least;
}
double flop_cost() {
  return std::min(flop_cost_in<FourLanes>(), flop_cost_in<EightLanes>());
}

// Seconds of one local solution that waits for the one before: for one component of its reaction or,
// `coupled`, for the product of a block and all of them, stored and read again as in a sweep. Contacts are
// visited one after the other, so that the processor learns their states by heart, or, `unforeseen`, in a
// random order too long to be learned: the difference is what branches on states cost that are missed.
template <bool coupled, class Problem>
double local_latency(const Problem& problem, const Eigen::VectorXd& r, bool unforeseen = false) {
  constexpr int N = Problem::n_unknowns;
  using Block = std::remove_cvref_t<decltype(problem.delassus.diagonal_block(0))>;
  const Index n = std::min<Index>(problem.n_contacts(), 200);
  Array<LocalSolver<N, Block>> local;
  Eigen::VectorXd u;
  contact_velocity(problem, r, u);
  for (Index c = 0; c < n; ++c) local.push_back(LocalSolver<N, Block>(problem.delassus.diagonal_block(c)));
  const volatile double tiny = 1e-30;
  Eigen::Matrix<double, N, N> block;
  for (Index i = 0; i < N * N; ++i) block.data()[i] = tiny;
  double carried = 0;
  Eigen::VectorXd handed = Eigen::VectorXd::Zero(N * n);
  constexpr Index n_visits = 40000;
  Array<std::int32_t> visits(n_visits), before(n_visits);
  std::mt19937_64 random(8);
  for (Index k = 0; k < n_visits; ++k) {
    const Index c = unforeseen ? static_cast<Index>(random() % static_cast<std::uint64_t>(n)) : k % n;
    visits[k] = static_cast<std::int32_t>(c);
    before[k] = k > 0 ? N * visits[k - 1] : 0;
  }
  double least = 1e300;
  for (int repetition = 0; repetition < 5; ++repetition) {
    const double start = jampack_bench::cpu_seconds();
    constexpr int times = 3;
    for (int i = 0; i < times; ++i)
      for (Index k = 0; k < n_visits; ++k) {
        const Index c = visits.data()[k];
        ContactVector<N> v, old;
#pragma GCC unroll 9
        for (int axis = 0; axis < N; ++axis) {
          v[axis] = u[N * c + axis];
          old[axis] = r[N * c + axis];
        }
        if constexpr (coupled) {
#pragma GCC unroll 9
          for (int entry = 0; entry < N * N; ++entry)
            v[entry % N] += block(entry % N, entry / N) * handed[before.data()[k] + entry / N];
        } else
          v[0] += block(0, 0) * carried;
        const ContactVector<N> next = local.data()[c].solve(problem.law.data()[c], v, old);
        if constexpr (coupled) {
#pragma GCC unroll 9
          for (int axis = 0; axis < N; ++axis) handed[N * c + axis] = next[axis];
        }
        carried = next[N - 1];
      }
    least = std::min(least, (jampack_bench::cpu_seconds() - start) / (times * static_cast<double>(n_visits)));
  }
  return least + 0 * (carried + handed[0]);
}

template <class Delassus>
constexpr bool is_stored = requires(const Delassus& delassus) {
  delassus.n_stored();
};

// Bytes of a contact besides its row of W: the local solution's block and inverse, the law, q and r.
template <class Problem>
double bytes_of_contact(const Problem&) {
  constexpr int N = Problem::n_unknowns;
  return sizeof(LocalSolver<N>) + sizeof(typename Problem::LocalLaw) + 2 * sizeof(double) * N;
}

template <class Problem>
void measure(const std::string& form, int dim, const Problem& problem, double scalars, double other_bytes,
             double flops, bool threads = true) {
  constexpr int N = Problem::n_unknowns;
  for (const int n_threads : {0, 1, 2}) {  // 0: natural order
    if (n_threads > 0 && !threads) continue;
    Eigen::VectorXd r = Eigen::VectorXd::Zero(problem.free_velocity.size());
    GaussSeidelSweeps sweeps(problem, r);
    if (n_threads > 0) sweeps.colour(problem, {n_threads});
    for (int k = 0; k < 3; ++k) sweeps.sweep(r);
    const std::string name = form + (n_threads > 0 ? ", coloured" : "") + ", D = " + std::to_string(dim) +
                             ", N = " + std::to_string(N) + ", " + std::to_string(problem.n_contacts()) +
                             " contacts, " + std::to_string(std::max(1, n_threads)) + " threads";
    cases[name] = {form + (n_threads > 0 ? " coloured" : ""),
                   dim,
                   N,
                   std::max(1, n_threads),
                   problem.n_contacts(),
                   scalars,
                   other_bytes,
                   flops,
                   local_latency<false>(problem, r),
                   is_stored<typename Problem::DelassusType> ? local_latency<true>(problem, r) : 0,
                   is_stored<typename Problem::DelassusType> ? local_latency<true>(problem, r, true)
                                                             : local_latency<false>(problem, r, true)};
    BENCHMARK(std::string(name)) {
      return sweeps.sweep(r);
    };
  }
}

// Random rows: each contact with 14 others near by, diagonally dominant.
template <int N>
auto stored_problem(Index n) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::uniform_int_distribution<Index> step(-200, 200);
  Array<DelassusBlock<N>> blocks;
  for (Index c = 0; c < n; ++c) {
    blocks.push_back({c, c, Eigen::Matrix<double, N, N>::Identity()});
    for (int k = 0; k < 14; ++k) {
      const Index d = k < 4 ? c + (k < 2 ? k - 2 : k - 1) : c + step(random);
      if (d == c || d < 0 || d >= n) continue;
      Eigen::Matrix<double, N, N> block;
      for (Index i = 0; i < block.size(); ++i) block.data()[i] = 0.02 * uniform(random);
      blocks.push_back({c, d, block});
    }
  }
  return BlockSparseDelassus<N>(n, std::move(blocks));
}

// A ring of grains, `size` contacts between neighbours, one dense compliance a grain.
template <int N>
auto dense_grains(Index n_grains, Index size) {
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Array<GrainCompliance<N>> grains(n_grains);
  const Index width = 2 * N * size;
  for (Index g = 0; g < n_grains; ++g) {
    for (Index k = 0; k < 2 * size; ++k) {
      grains[g].contact.push_back((g * size + k) % (n_grains * size));
      grains[g].sign.push_back(k < size ? -1 : 1);
    }
    grains[g].compliance = Eigen::MatrixXd::Identity(width, width);
    for (Index i = 0; i < width; ++i)
      for (Index j = 0; j < width; ++j)
        grains[g].compliance(i, j) += 0.3 / static_cast<double>(width) * uniform(random);
  }
  return GrainComplianceDelassus<N>(n_grains * size, std::move(grains));
}

template <class Delassus>
auto with_loads(Delassus delassus) {
  constexpr int N = Delassus::n_unknowns;
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  const Index n = delassus.n_contacts();
  Eigen::VectorXd q(N * n);
  for (Index i = 0; i < q.size(); ++i) q[i] = i % N == 0 ? -1 + 0.5 * normal(random) : 0.2 * normal(random);
  if constexpr (N == 1)
    return ContactProblem<Delassus, Signorini>(std::move(delassus), q, Array<Signorini>(n));
  else
    return ContactProblem<Delassus>(std::move(delassus), q, Array<SignoriniCoulomb>(n, {0.3}));
}

template <int N>
void measure_stored(int dim) {
  // In L1, in L2 (0.6 MB), in L3 (20 MB) and in memory (80 MB).
  for (const Index thousandth : {4, 500, 15000, 60000}) {
    const Index contacts = thousandth == 4 ? 4 : thousandth * 9 / (N * N);
    const auto problem = with_loads(stored_problem<N>(contacts));
    const double scalars = static_cast<double>(problem.delassus.n_stored()) / static_cast<double>(contacts);
    const double columns = 4 * scalars / (N * N);
    measure("block sparse", dim, problem, scalars, bytes_of_contact(problem) + columns, 2 * scalars,
            contacts > 10);
  }
}

template <int N>
void measure_dense(int dim) {
  for (const Index grains : {Index{3}, Index{12}, Index{150}}) {
    const Index size = grains == 3 ? 4 / N + 1 : grains == 12 ? 36 / N : 120 / N;
    const auto problem = with_loads(dense_grains<N>(grains, size));
    const double scalars =
        static_cast<double>(problem.delassus.n_stored()) / static_cast<double>(problem.n_contacts());
    measure("dense a grain", dim, problem, scalars, bytes_of_contact(problem), 2 * scalars, grains > 3);
  }
}

template <int Dim, int N>
void measure_balls(double packing_fraction) {
  // Scalars of a contact as the kernel holds them, and of its two bodies.
  const double scalars = N == 1 ? 20 : Dim == 2 ? 19 : 21;
  const double flops = N == 1 ? 4 * Dim * 3 : Dim == 2 ? 50 : 110;
  for (const Index balls : {20, 1000, 2000, 8000}) {
    auto problem = jampack_tests::pressed_packing<Dim, N>(balls, packing_fraction, 0.3, 1, 60);
    measure("rigid balls", Dim, problem, scalars, 0, flops, balls > 100);
    if (balls < 100) continue;
    // Walls that move together couple all their contacts: these are one thread's.
    problem.delassus = RigidBallsDelassus<Dim, N>(problem.delassus.bodies(), problem.delassus.contacts());
    measure("rigid balls, walls held", Dim, problem, scalars, 0, flops);
  }
}

void report() {
  CsvWriter csv("gauss_seidel_kernel.csv",
                {"form", "dim", "unknowns", "contacts", "bytes", "threads", "ns_per_contact", "ns_per_scalar",
                 "floor_bytes_ns", "floor_flops_ns", "floor_local_ns", "floor_chain_ns",
                 "chain_unforeseen_ns", "compiler", "flags", "commit"});
  const double flop = flop_cost();
  std::printf("\nmultiply-adds: %.1f Gflop/s; floors in ns a contact for one thread\n", 1e-9 / flop);
  std::printf("%-32s %2s %2s %8s %9s %7s %8s %9s | %7s %7s %7s %7s %10s | %s\n", "form", "D", "N", "contacts",
              "kB", "threads", "ns/cont", "ns/scalar", "bytes", "flops", "local", "chain", "unforeseen",
              "over the largest but the last");
  for (const auto& [name, c] : cases) {
    if (!shortest.contains(name)) continue;
    const double n = static_cast<double>(c.contacts), ns = 1e9 * shortest[name] / n;
    const double bytes = 1e9 * c.bytes() / n * read_cost(c.bytes()), flops = 1e9 * flop * c.flops,
                 local = 1e9 * c.local, chain = 1e9 * c.chain;
    std::printf("%-32s %2d %2d %8td %9.0f %7d %8.1f %9.3f | %7.1f %7.1f %7.1f %7.1f %10.1f | %.2f\n",
                c.form.c_str(), c.dim, c.unknowns, c.contacts, c.bytes() / 1024, c.threads, ns,
                ns / c.scalars, bytes, flops, local, chain, 1e9 * c.unforeseen,
                ns / std::max({bytes, flops, local, chain}));
    csv.write({c.form, c.dim, c.unknowns, c.contacts, c.bytes(), c.threads, ns, ns / c.scalars, bytes, flops,
               local, chain, 1e9 * c.unforeseen, jampack_bench::compiler(), jampack_bench::flags(),
               jampack_bench::commit()});
  }
}

// Wall seconds of work(thread) on so many threads at once: the least of some.
template <class Work>
double seconds_on(int n_threads, const Work& work) {
  double least = 1e300;
  for (int k = 0; k < 9; ++k) {
    const Stopwatch clock;
    parallel_for(Threads{n_threads}, n_threads, work);
    least = std::min(least, clock.seconds());
  }
  return least;
}

// What threads that share nothing gain: the bound of what a shared sweep can. Multiply-adds in registers, and
// sweeps over a packing that each has for itself.
void report_two_threads() {
  const auto multiply = [](Index) {
    TwoLanes a = {1, 1}, b = a;
    const TwoLanes factor = {0.999, 0.998};
    for (Index i = 0; i < 20000000; ++i) a = a * factor + b;
    volatile double sink = a[0] + a[1];
    (void)sink;
  };
  std::printf("\ntwo threads that share nothing over one: %.2f multiply-adds",
              2 * seconds_on(1, multiply) / seconds_on(2, multiply));
  using Problem = decltype(jampack_tests::pressed_packing<3, 3>(1000, 0.66, 0.3, 1, 60));
  const Array<Problem> problems(2, jampack_tests::pressed_packing<3, 3>(1000, 0.66, 0.3, 1, 60));
  Array<Eigen::VectorXd> r(2, Eigen::VectorXd::Zero(problems[0].free_velocity.size()));
  Array<std::unique_ptr<GaussSeidelSweeps<Problem>>> sweeps;
  for (Index t = 0; t < 2; ++t)
    sweeps.push_back(std::make_unique<GaussSeidelSweeps<Problem>>(problems[t], r[t]));
  const auto sweep = [&](Index t) {
    for (int k = 0; k < 300; ++k) sweeps[t]->sweep(r[t]);
  };
  std::printf(", %.2f sweeps over 1000 spheres each\n", 2 * seconds_on(1, sweep) / seconds_on(2, sweep));
}

}  // namespace

TEST_CASE("rigid balls") {
  measure_balls<3, 3>(0.66);
  measure_balls<3, 1>(0.66);
  measure_balls<2, 2>(0.86);
  measure_balls<2, 1>(0.86);
}

TEST_CASE("block sparse") {
  measure_stored<3>(3);
  measure_stored<2>(2);
  measure_stored<1>(3);
}

TEST_CASE("dense a grain") {
  measure_dense<3>(3);
  measure_dense<2>(2);
  measure_dense<1>(3);
}

int main(int argc, char** argv) {
  Catch::Session session;
  session.configData().benchmarkSamples = 15;
  session.configData().benchmarkNoAnalysis = true;
  if (const int failed = session.applyCommandLine(argc, argv); failed != 0) return failed;
  const int failed = session.run();
  report();
  report_two_threads();
  return failed;
}
