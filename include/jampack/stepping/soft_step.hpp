// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/solver/anderson.hpp>
#include <jampack/solver/proximal_newton.hpp>
#include <jampack/stepping/augmented_balance.hpp>
#include <jampack/stepping/condensed_contacts.hpp>
#include <jampack/stepping/coupled_newton.hpp>
#include <jampack/stepping/soft_step_options.hpp>
#include <optional>
#include <utility>

namespace jampack {

/// One implicit Moreau-Jean step of a packing of deformable grains under exact contact
/// (docs/theory/deformable_stage.md): condensed contact problems one after the other, the potential of the
/// augmented Lagrangian the judge of every move. Contacts keep their frames while grains move little, and are
/// detected afresh before a step is accepted.
template <class Packing, ContactLaw Law, class Solver = ProximalNewton, class Discretisation = SampledContact>
class SoftStep {
 public:
  static constexpr int Dim = Packing::dimension;
  static constexpr int N = n_contact_unknowns<Law, Dim>;
  using Nodal = typename Packing::Nodal;
  using Watched = WatchedContacts<Packing, Law, Discretisation>;
  using Condensed = CondensedContacts<typename CondensedStep<Packing, Law>::Problem>;

  Law law;
  SoftStepOptions options;
  Watched contacts;  ///< with the forces of the last accepted step

  SoftStep(Law contact_law, SoftStepOptions step_options) : law(contact_law), options(step_options) {}

  /// Advances `packing` by h, the room's scale going to `new_scale`. On failure the packing and the
  /// contacts are as they were, unless something else is asked for.
  SoftStepReport advance(Packing& packing, double h, double new_scale, FirstGuess guess = FirstGuess::flight,
                         Unfinished unfinished = Unfinished::undone) {
    const auto saved = contacts;
    const double old_scale = std::exchange(packing.room.scale, new_scale);
    failed_.reset();
    SoftStepReport report;
    try {
      solve(packing, h, guess, report);
    } catch (const NotConverged& error) {
      report.near_balance = false;
      fail(report, error.what());
    } catch (...) {
      packing.room.scale = old_scale;
      contacts = saved;
      throw;
    }
    report.kept = !report.converged && report.near_balance && unfinished == Unfinished::kept;
    if (report.kept) balance_.accept_forces(contacts);
    if (report.converged || report.kept) {
      for (Index g = 0; g < packing.grains.size(); ++g) {
        auto& grain = packing.grains[g];
        grain.velocity =
            ((balance_.x[g] - grain.position) / h - (1 - options.theta) * grain.velocity) / options.theta;
        grain.position = balance_.x[g];
      }
    } else {
      failed_.emplace(packing, std::move(contacts));
      packing.room.scale = old_scale;
      contacts = saved;
    }
    return report;
  }

  /// The first contact problem that advance() would meet with these arguments. Throws NotConverged where a
  /// grain cannot be linearised.
  Condensed contact_problem(Packing packing, double h, double new_scale,
                            FirstGuess guess = FirstGuess::flight) {
    packing.room.scale = new_scale;
    failed_.reset();
    Watched watched = contacts;
    if (!begin(packing, h, guess, watched)) throw NotConverged(inverted);
    return condense(packing, watched);
  }

  /// The contact problem before which the last step was given up, with the forces it had reached; none where
  /// it was not given up, or a grain cannot be linearised there.
  std::optional<Condensed> failed_contact_problem() {
    if (!failed_) return {};
    const auto& [packing, watched] = *failed_;
    if (!balance_.linearise(packing)) return {};
    try {
      return condense(packing, watched);
    } catch (const NotConverged&) {
      return {};
    }
  }

 private:
  static constexpr const char* inverted = "a cell is inverted at the start of the step";

  /// Sets up the balance of the step at its first guess, contact detected there; false where a cell is
  /// inverted.
  bool begin(const Packing& packing, double h, FirstGuess guess, Watched& watched) {
    const double d = packing.mean_diameter();
    reach_ = options.reach * d;
    balance_.law = law;
    balance_.threads = condensed_.threads = options.threads;
    balance_.theta = options.theta;
    balance_.least_force = options.least_pressure * packing.model->material.young * std::pow(d, Dim - 1);
    // Invariants of a cell that is hardly strained are differences of numbers near one.
    potential_round_off_ =
        1e-14 * packing.model->material.young * std::pow(d, Dim) * double(packing.grains.size());
    balance_.penalty = options.penalty;
    if (!balance_.begin(packing, h, guess == FirstGuess::flight)) return false;
    last_move_ = since_frames_ = std::numeric_limits<double>::infinity();
    mixing_.forget();
    unsolved_ = false;
    last_.reset();
    // Where the first guess is far off, all finer samples would be hit.
    watched.find(packing, balance_.x, reach_, SampleSet::coarse, options.threads);
    balance_.evaluate(packing, watched);
    return true;
  }

  void solve(const Packing& packing, double h, FirstGuess guess, SoftStepReport& report) {
    if (!begin(packing, h, guess, contacts)) return fail(report, inverted);
    const double d = packing.mean_diameter();
    const double frame_move = 1e-2 * d;  // grains that move by more take their contacts' frames with them
    constexpr int most_rounds = 8;       // of contact detected afresh
    constexpr int patience = 20;         // iterations near the end that bring nothing; long ones count more
    int rounds = 0, renewals = 0, without_gain = 0;
    double least = std::numeric_limits<double>::infinity();
    for (;; ++report.iterations) {
      double left = judge(report);
      if (balance_.balanced(options.tolerance, options.scaled_tolerance, options.surface_tolerance)) {
        if (holds_afresh(packing, report)) {
          report.converged = true;
          return;
        }
        left = judge(report);
        if (++rounds == most_rounds) return fail(report, "contact frames do not settle");
        least = std::numeric_limits<double>::infinity();
        without_gain = 0;
        // Frames that turn with every solution must turn in smaller pieces.
        renewals = 2 * (rounds - 1);
        if (rounds == 1 && last_ && couple(packing)) continue;
      }
      // Far from the end the residual says little: a packing on its way down passes larger ones.
      without_gain = left < least || left > 1e-3 ? 0 : without_gain + (unsolved_ ? 5 : 1);
      least = std::min(least, left);
      if (without_gain >= patience)
        return fail(report, "no better balance in " + std::to_string(patience) + " iterations");
      if (report.iterations >= options.max_iterations)
        return fail(report, "no balance after " + std::to_string(options.max_iterations) + " iterations");
      const bool renew = renewals > 0;
      if (!iterate(packing, report, renew || since_frames_ > frame_move))
        return fail(report, "no part of a move lowers the potential");
      if (renew) --renewals;
      if (renewals == 0) couple(packing);
    }
  }

  /// Writes what is left of balance and law; the larger of both.
  double judge(SoftStepReport& report) const {
    report.equilibrium_residual = balance_.equilibrium_residual();
    report.scaled_residual = balance_.contact_residual;
    const double left = std::max(report.equilibrium_residual, balance_.surface_residual);
    report.near_balance = left < 1e-2;
    return left;
  }

  static void fail(SoftStepReport& report, std::string reason) {
    report.converged = false;
    report.reason = std::move(reason);
  }

  /// Whether the forces also balance on contacts detected afresh; if not, those are the contacts from now on.
  bool holds_afresh(const Packing& packing, SoftStepReport& report) {
    balance_.accept_forces(contacts);
    const auto solved = contacts;  // with the frames they were solved in
    contacts.find(packing, balance_.x, reach_, SampleSet::all, options.threads);
    since_frames_ = 0;
    balance_.evaluate(packing, contacts);
    report.fresh = balance_.equilibrium_residual();
    constexpr double any = std::numeric_limits<double>::infinity();
    if (!balance_.balanced(options.fresh_tolerance, any, options.fresh_contact_tolerance)) return false;
    contacts = solved;
    return true;
  }

  /// The step that the condensed contact problem asks for, with its reactions as multipliers, as far as the
  /// potential falls; false when it falls nowhere along it: x is then as it was.
  bool iterate(const Packing& packing, SoftStepReport& report, bool new_frames) {
    Eigen::VectorXd dx;
    solve_condensed(packing, report, dx);
    const auto start = balance_.x;
    balance_.hold_bounds(contacts, contacts.pairs.reaction);
    const double before = balance_.potential(packing, contacts);
    for (double length = longest(packing, dx); length > 1e-3; length *= 0.5) {
      place(start, length, dx);
      const double now = balance_.potential(packing, contacts);
      if (!(now <= before + potential_round_off_)) continue;
      // The stand-ins are stiffer than the tangents: the move may be longer, or a combination of the last
      // ones.
      if (length == 1) accelerate(packing, start, dx, now, new_frames);
      if (length < 1 || new_frames) mixing_.forget();
      since_frames_ += last_move_;
      balance_.linearise(packing);
      if (new_frames) {
        contacts.refresh(packing, balance_.x, reach_, options.threads);
        since_frames_ = 0;
      }
      balance_.evaluate(packing, contacts);
      return true;
    }
    balance_.x = start;
    return false;
  }

  /// Moves to a combination of the last moves, or further along start + dx, where the potential is `now`, as
  /// long as that brings it down.
  void accelerate(const Packing& packing, const Array<Nodal>& start, const Eigen::VectorXd& dx, double now,
                  bool new_frames) {
    const auto try_step = [&](const Eigen::VectorXd& step, double expected) {
      const auto here = balance_.x;
      const double move = last_move_;
      if (longest(packing, step) == 1) {
        place(start, 1, step);
        if (const double there = balance_.potential(packing, contacts); there <= now - expected) {
          now = there;
          return true;
        }
      }
      balance_.x = here;
      last_move_ = move;
      return false;
    };
    if (!new_frames && !try_step(mixing_.step(flat(start), dx), 0)) mixing_.forget();
    for (double length = 2; length <= 16 && try_step(length * dx, potential_round_off_);) length *= 2;
  }

  /// Solves the contact problem of the grains condensed on their contacts: its reactions become the
  /// multipliers, dx the motion that goes with them.
  void solve_condensed(const Packing& packing, SoftStepReport& report, Eigen::VectorXd& dx) {
    last_.emplace(condense(packing, contacts));
    const SolveReport solved = solve_contacts(last_->problem, last_->guess);
    report.sweeps += solved.sweeps;
    unsolved_ = !solved.converged;
    take_over(*last_, contacts);
    condensed_.motion(last_->guess, dx);
  }

  /// How far from the end, in units of the tolerances.
  double distance() const {
    return std::max({balance_.residual_norm / (options.tolerance * balance_.force_scale + balance_.round_off),
                     balance_.contact_residual / options.scaled_tolerance,
                     balance_.surface_residual / options.surface_tolerance});
  }

  /// Newton's method with the exact tangents from where the last iteration has led; whether it gained.
  bool couple(const Packing& packing) {
    if (distance() <= 1) return false;
    CoupledNewton<Packing, Law> newton(condensed_, *last_, options.threads);
    const auto moved = newton.run(
        packing, longest_move(packing), potential_round_off_, [&](const auto&) { return distance(); },
        balance_, contacts);
    if (!moved) return false;
    last_move_ = *moved;
    since_frames_ += *moved;
    mixing_.forget();
    return true;
  }

  /// As the iteration converges, ever fewer open contacts can close. One that was left out and does close is
  /// in the next problem.
  Condensed condense(const Packing& packing, const Watched& watched) {
    const double d = packing.mean_diameter();
    return jampack::condense(packing, watched, balance_, condensed_,
                             d * std::clamp(0.3 * last_move_ / d, 1e-5, 3e-4));
  }

  /// Solves as far as the step's own residuals make it worth while.
  template <class Problem>
  SolveReport solve_contacts(const Problem& problem, Eigen::VectorXd& r) const {
    const double surface = balance_.surface_residual;
    // What this residual may be for both measures of the law to hold.
    const double enough =
        std::min(options.surface_tolerance,
                 options.scaled_tolerance * surface / std::max(balance_.contact_residual, 1e-300));
    Solver solver;
    // Few problems need so many; one that is given up early leads nowhere, and takes the whole step with it.
    solver.stop.max_sweeps = 200;
    solver.stop.tolerance =
        std::min(options.contact_tolerance,
                 std::max({0.3 * surface, 0.03 * balance_.equilibrium_residual(), 0.2 * enough}));
    // Forces next to none need not be right.
    if (const double size = r.norm(); size > 0)
      solver.stop.tolerance *=
          std::max(1.0, balance_.least_force / std::max(size, 1e-3 * balance_.least_force));
    if constexpr (requires { solver.regularisation; }) solver.regularisation = 0.1;
    if constexpr (requires { solver.max_rounds; }) solver.max_rounds = 20;
    if constexpr (requires { solver.threads; }) solver.threads = options.threads;
    return solver.solve(problem, r);
  }

  /// All unknowns, grain by grain.
  static Eigen::VectorXd flat(const Array<Nodal>& x) {
    const Index n = x[0].size();
    Eigen::VectorXd all(n * x.size());
    for (Index g = 0; g < x.size(); ++g)
      all.segment(n * g, n) = Eigen::Map<const Eigen::VectorXd>(x[g].data(), n);
    return all;
  }

  /// No node may move by more than half an edge.
  static double longest_move(const Packing& packing) {
    return 0.5 * packing.model->boundary.edge_length * packing.mean_diameter();
  }
  /// The longest step that keeps to that.
  static double longest(const Packing& packing, const Eigen::VectorXd& dx) {
    return std::min(1.0, longest_move(packing) /
                             std::max(dx.lpNorm<Eigen::Infinity>(), std::numeric_limits<double>::min()));
  }

  void place(const Array<Nodal>& start, double length, const Eigen::VectorXd& dx) {
    last_move_ = length * dx.lpNorm<Eigen::Infinity>();
    const Index n = start[0].size();
    for (Index g = 0; g < start.size(); ++g)
      balance_.x[g] = start[g] + length * Eigen::Map<const Nodal>(dx.data() + n * g, Dim, start[g].cols());
  }

  AugmentedBalance<Packing, Law> balance_;
  CondensedStep<Packing, Law> condensed_;
  Anderson mixing_;
  std::optional<Condensed> last_;  ///< the contact problem of the last iteration, with its solution
  /// The packing and the contacts of a step that failed, as it was given up; balance_ still is there too.
  std::optional<std::pair<Packing, Watched>> failed_;
  double potential_round_off_ = 0;
  double reach_ = 0;         ///< detection distance
  double last_move_ = 0;     ///< largest displacement of a node in the last iteration
  double since_frames_ = 0;  ///< the same since frames were renewed, added up
  bool unsolved_ = false;    ///< the last contact problem, within the iterations it may take
};

}  // namespace jampack
