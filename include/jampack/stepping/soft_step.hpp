// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/detection/surface_detection.hpp>
#include <jampack/geometry/frame.hpp>
#include <jampack/law/signorini.hpp>
#include <jampack/problem/residual.hpp>
#include <jampack/solver/anderson.hpp>
#include <jampack/solver/gmres.hpp>
#include <jampack/solver/proximal_newton.hpp>
#include <jampack/stepping/augmented_force.hpp>
#include <jampack/stepping/condensed_step.hpp>
#include <jampack/stepping/newton_system.hpp>

namespace jampack {

/// How one implicit step is solved. docs/results/compaction.md says how the defaults came about.
struct SoftStepOptions {
  double theta = 1;               ///< of the Moreau-Jean scheme, in [0.5, 1]
  double tolerance = 5e-7;        ///< on the equilibrium residual and on the scaled contact residual
  double fresh_tolerance = 3e-4;  ///< on both with contact detected afresh at the end of the step
  int max_iterations = 60;        ///< Newton iterations before the step is given up
  double penalty = 10;  ///< augmentation, in units of the stiffness of a surface layer one edge thick
  double linear_tolerance = 0.05;   ///< of the inner linear solves, relative
  Index contact_sweeps = 60;        ///< of one condensed contact problem; the best iterate is taken then
  double newton_below = 1e-3;       ///< equilibrium residual below which the exact tangents are tried
  double contact_tolerance = 1e-3;  ///< of condensed contact problems, on their scaled residual
  double reach = 0.03;              ///< detection distance over the mean diameter
  double least_pressure = 1e-6;     ///< forces below this times Young's modulus and d^(Dim-1) are none
  Threads threads;
};

/// What one step cost and reached.
struct SoftStepReport {
  bool converged = false;
  int iterations = 0;
  int condensed = 0;  ///< of them, by a condensed contact problem
  Index sweeps = 0;
  Index linear_iterations = 0;
  double equilibrium_residual = 0;  ///< |M dv - h (f_ext - f_int) - H^T r| / |H^T r|, the step's own frames
  double scaled_residual = 0;       ///< of the contacts, the step's own frames
  double fresh = 0;                 ///< the larger of both with contact detected afresh
  std::string reason;               ///< why it failed
};

/// One implicit Moreau-Jean step of a packing of deformable grains under exact contact
/// (docs/theory/deformable_stage.md): contacts keep their frames while Newton's method works on internal
/// forces and contact forces together, and take new ones as it converges.
template <class Packing, ContactLaw Law, class Solver = ProximalNewton>
class SoftStep {
 public:
  static constexpr int Dim = Packing::dimension;
  static constexpr int N = n_contact_unknowns<Law, Dim>;
  using Nodal = typename Packing::Nodal;

  Law law;
  SoftStepOptions options;
  SurfaceContacts<Dim, N> pairs;  ///< grain against grain, with the forces of the last accepted step
  SurfaceContacts<Dim, 1> walls;  ///< grain against wall

  SoftStep(Law contact_law, SoftStepOptions step_options) : law(contact_law), options(step_options) {}

  /// Advances `packing` by h, the room's scale going to `new_scale`. On failure the packing and the
  /// contacts are as they were.
  SoftStepReport advance(Packing& packing, double h, double new_scale) {
    const auto saved_pairs = pairs;
    const auto saved_walls = walls;
    const double old_scale = packing.room.scale;
    packing.room.scale = new_scale;
    h_ = h;
    auto report = solve(packing);
    if (report.converged) {
      for (Index g = 0; g < packing.grains.size(); ++g) {
        auto& grain = packing.grains[g];
        grain.velocity =
            ((x_[g] - grain.position) / h - (1 - options.theta) * grain.velocity) / options.theta;
        grain.position = x_[g];
      }
    } else {
      packing.room.scale = old_scale;
      pairs = saved_pairs;
      walls = saved_walls;
    }
    return report;
  }

 private:
  SoftStepReport solve(Packing& packing) {
    SoftStepReport report;
    if (!start(packing)) return fail(report, "a cell is inverted at the start of the step");
    int wait = 0, patience = 2;
    int refreshed = 0, rounds = 0;
    constexpr int frame_updates = 8;
    int slow = 0;
    double last_update = 0;
    for (;; ++report.iterations) {
      report.equilibrium_residual = residual_norm_ / force_scale_;
      report.scaled_residual = contact_residual_;
      if (balanced(options.tolerance)) {
        accept_forces();
        const auto solved_pairs = pairs;  // with the frames they were solved in
        const auto solved_walls = walls;
        const bool news = find_contacts(packing);
        const double penalty = std::exchange(penalty_, 0.0);  // the forces as they are, on what they now meet
        evaluate(packing);
        penalty_ = penalty;
        report.fresh = std::max(residual_norm_ / force_scale_, contact_residual_);
        if (!news && balanced(options.fresh_tolerance)) {
          pairs = solved_pairs;
          walls = solved_walls;
          report.converged = true;
          return report;
        }
        if (++rounds == 4) return fail(report, "contact frames do not settle");
        refreshed = std::min(refreshed, frame_updates - 2);
        evaluate(packing);
      }
      // The multipliers move only once balance at the old ones is ahead of the contact conditions.
      if (const double update = update_norm(packing); residual_norm_ <= 0.3 * update) {
        // Contacts that hinder each other pass their forces on slowly, unless the penalty is high.
        if (last_update > 0 && update > 0.5 * last_update) {
          if (++slow >= 2) {
            penalty_ = std::min(4 * penalty_, 256 * options.penalty);
            slow = 0;
          }
        } else
          slow = 0;
        last_update = update;
        accept_forces();
        if (refreshed++ < frame_updates) refresh(packing);
        evaluate(packing);
      }
      if (report.iterations == options.max_iterations)
        return fail(report, "Newton's method did not converge in " + std::to_string(options.max_iterations) +
                                " iterations");
      const double before = residual_norm_;
      assemble(packing);
      // Far from the solution contacts are sorted out by a contact solver; close to it, where the same
      // contacts stick and slip from one iteration to the next, the exact tangents pay.
      if (before > options.newton_below * force_scale_ || wait > 0) {
        --wait;
        penalty_ = options.penalty;
        last_update = 0;
        slow = 0;
        if (!condensed_iteration(packing, report, refreshed++ < frame_updates))
          return fail(report, "a cell is inverted");
      } else {
        mixing_.forget();
        const bool fell = newton_iteration(packing, report);
        if (!fell || residual_norm_ > 0.5 * before) wait = patience = 2 * patience;
      }
    }
  }

  static SoftStepReport fail(SoftStepReport report, std::string reason) {
    report.converged = false;
    report.reason = std::move(reason);
    return report;
  }

  bool balanced(double tolerance) const {
    return residual_norm_ <= tolerance * force_scale_ + round_off_ && contact_residual_ <= tolerance;
  }

  /// First guess, contacts and forces of a step; false when no shape is free of inverted cells.
  bool start(const Packing& packing) {
    const Index n_grains = packing.grains.size();
    x_.resize(n_grains);
    force_.resize(n_grains);
    old_force_.resize(n_grains);
    residual_.resize(n_grains);
    surfaces_.resize(n_grains);
    system_.threads = options.threads;
    condensed_.threads = options.threads;
    system_.resize(packing);
    penalty_ = options.penalty;
    has_factor_ = false;
    last_move_ = std::numeric_limits<double>::infinity();
    mixing_.forget();
    for (Index g = 0; g < n_grains; ++g) {
      const auto& grain = packing.grains[g];
      x_[g] = grain.position + h_ * grain.velocity;
      if (options.theta < 1) grain.internal_force(*packing.model, grain.position, old_force_[g]);
    }
    if (!internal_forces(packing)) {
      // The extrapolated shapes are no use: start from those of the last step.
      for (Index g = 0; g < n_grains; ++g) x_[g] = packing.grains[g].position;
      if (!internal_forces(packing)) return false;
    }
    find_contacts(packing);
    evaluate(packing);
    return true;
  }

  /// Internal forces and tangents at x_; false when a cell is inverted.
  bool internal_forces(const Packing& packing) {
    Array<char> good(packing.grains.size(), 1);
    parallel_for(options.threads, packing.grains.size(), [&](Index g) {
      good[g] =
          packing.grains[g].internal_force_and_tangent(*packing.model, x_[g], force_[g], system_.tangent[g]);
    });
    return std::all_of(good.begin(), good.end(), [](char ok) { return ok != 0; });
  }

  /// Detects at x_; true when a contact came in that penetrates and was not watched before.
  bool find_contacts(const Packing& packing) {
    const double d = packing.mean_diameter();
    update_surfaces(packing);
    Array<SurfaceContact<Dim>> fresh_pairs, fresh_walls;
    detect(surfaces_, packing.room, DetectionRange{options.reach * d, 0.1 * d}, options.threads, fresh_pairs,
           fresh_walls);
    const bool news = penetrates_unseen(pairs, fresh_pairs) || penetrates_unseen(walls, fresh_walls);
    replace_contacts(pairs, fresh_pairs);
    replace_contacts(walls, fresh_walls);
    detected_at_ = x_;
    project(packing);
    return news;
  }

  template <int M>
  static bool penetrates_unseen(const SurfaceContacts<Dim, M>& set, const Array<SurfaceContact<Dim>>& fresh) {
    Index old = 0;
    for (const auto& contact : fresh) {
      while (old < set.size() && set.contact[old].key() < contact.key()) ++old;
      const bool seen = old < set.size() && set.contact[old].key() == contact.key();
      if (!seen && contact.gap < 0) return true;
    }
    return false;
  }

  void update_surfaces(const Packing& packing) {
    parallel_for(options.threads, packing.grains.size(), [&](Index g) {
      surfaces_[g].update(packing.model->boundary, x_[g], packing.grains[g].diameter);
    });
  }

  /// New frames for the contacts; new contacts too where grains have moved far since the last detection.
  void refresh(const Packing& packing) {
    double moved = 0;
    for (Index g = 0; g < packing.grains.size(); ++g)
      moved = std::max(moved, (x_[g] - detected_at_[g]).colwise().norm().maxCoeff());
    if (moved > 0.3 * options.reach * packing.mean_diameter()) {
      find_contacts(packing);
    } else {
      update_surfaces(packing);
      project(packing);
    }
  }

  /// Frames of the watched grain-grain contacts at x_.
  void project(const Packing& packing) {
    constexpr Index chunk = 64;
    const auto& samples = packing.model->boundary.samples;
    parallel_for(options.threads, (pairs.size() + chunk - 1) / chunk, [&](Index k) {
      for (Index c = k * chunk; c < std::min(pairs.size(), (k + 1) * chunk); ++c) {
        auto& contact = pairs.contact[c];
        const Vector<Dim> x =
            surfaces_[contact.candidate].sample_point(samples[contact.sample], x_[contact.candidate]);
        const auto& other = surfaces_[contact.antagonist];
        contact.set(other, other.project(x, contact.face));
      }
    });
  }

  /// What resists a force at one sample in a step: a surface layer one edge thick under the sample's area,
  /// and the mass of a node. About N / tr W_cc, so that the contact residual measured with it is the scaled
  /// one.
  double contact_stiffness(const Packing& packing, const SurfaceContact<Dim>& contact) const {
    const auto& boundary = packing.model->boundary;
    const auto& grain = packing.grains[contact.candidate];
    const double size = Dim == 2 ? 1.0 : grain.diameter;
    const double layer = 8 * packing.model->material.young * boundary.node_area / boundary.edge_length * size;
    return layer + grain.mass.mean() / (options.theta * h_ * h_);
  }

  Vector<Dim> sample_point(const Packing& packing, const SurfaceContact<Dim>& contact, const Nodal& x) const {
    return surfaces_[contact.candidate].sample_point(packing.model->boundary.samples[contact.sample], x);
  }

  /// Displacement of a contact in the step: gap along the normal, slip across it (eq. 5), frames as they are.
  Vector<Dim> displacement(const Packing& packing, const SurfaceContact<Dim>& contact) const {
    const auto& grain = packing.grains[contact.candidate];
    const Vector<Dim> point = sample_point(packing, contact, x_[contact.candidate]);
    if (contact.is_wall())
      return packing.room.gap(contact.wall(), point) * contact.normal + contact.slack * contact.normal;
    const auto& other = packing.grains[contact.antagonist];
    const Vector<Dim> apart = point - contact.antagonist_point(x_[contact.antagonist]);
    const Vector<Dim> before =
        sample_point(packing, contact, grain.position) - contact.antagonist_point(other.position);
    const Vector<Dim> relative = apart - before;
    const double gap = contact.normal.dot(apart) + contact.slack;
    return relative + (gap - contact.normal.dot(relative)) * contact.normal;
  }

  /// Contact forces at x_ and what they leave of balance and contact conditions.
  void evaluate(const Packing& packing) {
    trial_pairs_.resize(pairs.size());
    trial_walls_.resize(walls.size());
    double error = 0;
    const auto visit = [&](auto& set, auto& trial, const auto& contact_law, Index c) {
      constexpr int M = std::decay_t<decltype(trial[c])>::RowsAtCompileTime;
      auto& contact = set.contact[c];
      const Vector<Dim> s = displacement(packing, contact);
      contact.gap = contact.normal.dot(s);
      const double k = contact_stiffness(packing, contact);
      const AugmentedForce<Dim> augmented(set.force(c), s, contact.normal, contact_law.friction,
                                          penalty_ * k);
      if constexpr (M == 1)
        trial[c][0] = augmented.open ? 0.0 : contact.normal.dot(augmented.force);
      else
        trial[c] = augmented.force;
      const Eigen::Matrix<double, M, Dim> axes = contact_frame<Dim>(contact.normal).template topRows<M>();
      return natural_map<M>(contact_law, ContactVector<M>(axes * augmented.force), ContactVector<M>(axes * s),
                            k)
          .squaredNorm();
    };
    for (Index c = 0; c < pairs.size(); ++c) error += visit(pairs, trial_pairs_, law, c);
    for (Index c = 0; c < walls.size(); ++c) error += visit(walls, trial_walls_, Signorini{}, c);
    double size = 0;
    for (const auto& r : trial_pairs_) size += r.squaredNorm();
    for (const auto& r : trial_walls_) size += r.squaredNorm();
    contact_residual_ = std::sqrt(error) / std::max(std::sqrt(size), least_force(packing));
    balance(packing);
  }

  double least_force(const Packing& packing) const {
    return options.least_pressure * packing.model->material.young *
           std::pow(packing.mean_diameter(), Dim - 1);
  }

  /// Adds the nodal forces of one contact to `nodal`.
  void scatter(const Packing& packing, const SurfaceContact<Dim>& contact, const Vector<Dim>& force,
               Array<Nodal>& nodal) const {
    const auto& sample = packing.model->boundary.samples[contact.sample];
    for (Index i = 0; i < sample.n; ++i)
      nodal[contact.candidate].col(sample.node[std::size_t(i)]) += sample.weight[i] * force;
    for (Index i = 0; i < contact.n_nodes; ++i)
      nodal[contact.antagonist].col(contact.node[std::size_t(i)]) -= contact.weight[i] * force;
  }

  template <class Reactions, int M>
  void scatter_all(const Packing& packing, const SurfaceContacts<Dim, M>& set, const Reactions& reaction,
                   Array<Nodal>& nodal) const {
    for (Index c = 0; c < set.size(); ++c)
      if (!reaction[c].isZero(0)) scatter(packing, set.contact[c], set.force(c, reaction[c]), nodal);
  }

  /// Imbalance of momentum without contact forces, as forces.
  Nodal imbalance(const Packing& packing, Index g) const {
    const auto& grain = packing.grains[g];
    const Nodal dv = ((x_[g] - grain.position) / h_ - grain.velocity) / options.theta;
    Nodal sum = dv * (grain.mass / h_).asDiagonal() + options.theta * force_[g];
    if (options.theta < 1) sum += (1 - options.theta) * old_force_[g];
    return sum;
  }

  /// Residual of the balance of momentum (eq. 6).
  void balance(const Packing& packing) {
    const Index n_grains = packing.grains.size();
    contact_nodal_.resize(n_grains);
    for (auto& f : contact_nodal_) f.setZero(Dim, packing.n_nodes());
    scatter_all(packing, pairs, trial_pairs_, contact_nodal_);
    scatter_all(packing, walls, trial_walls_, contact_nodal_);
    double error = 0, size = 0, inertia = 0;
    for (Index g = 0; g < n_grains; ++g) {
      inertia += x_[g].colwise().squaredNorm().dot(packing.grains[g].mass.cwiseAbs2());
      residual_[g] = imbalance(packing, g) - contact_nodal_[g];
      error += residual_[g].squaredNorm();
      size += contact_nodal_[g].squaredNorm();
    }
    residual_norm_ = std::sqrt(error);
    round_off_ = std::numeric_limits<double>::epsilon() * std::sqrt(inertia) / (options.theta * h_ * h_);
    force_scale_ = std::max(std::sqrt(size), least_force(packing));
  }

  void accept_forces() {
    pairs.reaction = trial_pairs_;
    walls.reaction = trial_walls_;
  }

  /// Force that a change of the multipliers to the trial forces would make.
  double update_norm(const Packing& packing) {
    update_nodal_.resize(packing.grains.size());
    for (auto& f : update_nodal_) f.setZero(Dim, packing.n_nodes());
    const auto add = [&](const auto& set, const auto& trial) {
      for (Index c = 0; c < set.size(); ++c)
        if (const auto change = (trial[c] - set.reaction[c]).eval(); !change.isZero(0))
          scatter(packing, set.contact[c], set.force(c, change), update_nodal_);
    };
    add(pairs, trial_pairs_);
    add(walls, trial_walls_);
    double sum = 0;
    for (const auto& f : update_nodal_) sum += f.squaredNorm();
    return std::sqrt(sum);
  }

  /// theta K + M / (theta h^2) from K.
  void add_inertia(const Packing& packing, Index g, BlockMatrix<Dim>& tangent) const {
    const auto& pattern = packing.model->pattern;
    if (options.theta != 1)
      for (auto& block : tangent.block) block *= options.theta;
    const double factor = 1 / (options.theta * h_ * h_);
    for (Index i = 0; i < pattern.n_rows(); ++i)
      tangent.block[pattern.position(i, i)].diagonal().array() += factor * packing.grains[g].mass[i];
  }

  /// T of every grain and the stiffness of its contacts (eq. 9).
  void assemble(const Packing& packing) {
    parallel_for(options.threads, packing.grains.size(),
                 [&](Index g) { add_inertia(packing, g, system_.tangent[g]); });
    system_.couplings.clear();
    const auto add = [&](const auto& set, double friction) {
      for (Index c = 0; c < set.size(); ++c) {
        const auto& contact = set.contact[c];
        const double rho = penalty_ * contact_stiffness(packing, contact);
        const AugmentedForce<Dim> augmented(set.force(c), displacement(packing, contact), contact.normal,
                                            friction, rho);
        if (augmented.open) continue;
        const bool normal_only = friction == 0;
        const Matrix<Dim> nn = rho * contact.normal * contact.normal.transpose();
        system_.add(packing.model->boundary.samples[contact.sample], contact,
                    normal_only ? nn : augmented.stiffness(contact.normal, friction, rho),
                    normal_only ? nn : augmented.definite(contact.normal, rho));
      }
    };
    add(pairs, law.friction);
    add(walls, 0.0);
    system_.finish();
  }

  /// One Newton iteration on the augmented Lagrangian; false when the residual does not fall along it (x_ is
  /// left as it was).
  bool newton_iteration(const Packing& packing, SoftStepReport& report) {
    if (!has_factor_ || last_linear_ > 2 * fresh_linear_ + 10) {
      system_.factorise();
      has_factor_ = false;
    }
    system_.coarsen(x_);
    const Index n = Dim * packing.n_nodes();
    Eigen::VectorXd rhs(n * packing.grains.size()), dx;
    for (Index g = 0; g < packing.grains.size(); ++g)
      rhs.segment(n * g, n) = -Eigen::Map<const Eigen::VectorXd>(residual_[g].data(), n);
    Gmres gmres;
    gmres.tolerance = options.linear_tolerance;
    const auto linear = gmres.solve([&](const auto& a, auto& b) { system_.apply(a, b); },
                                    [&](const auto& a, auto& b) { system_.precondition(a, b); }, rhs, dx);
    report.linear_iterations += linear.iterations;
    last_linear_ = linear.iterations;
    if (!has_factor_) fresh_linear_ = last_linear_;
    has_factor_ = true;
    if (!dx.allFinite()) return false;
    const auto start = x_;
    const double before = residual_norm_;
    double length = longest(packing, dx);
    for (int cut = 0; cut < 3; ++cut, length *= 0.5) {
      if (!move(packing, start, length, dx)) continue;
      evaluate(packing);
      if (residual_norm_ <= (1 - 0.05 * length) * before) return true;
    }
    move(packing, start, 0, dx);
    evaluate(packing);
    return false;
  }

  /// The step that the condensed contact problem asks for, with its reactions as multipliers; false when
  /// every part of it inverts a cell.
  bool condensed_iteration(const Packing& packing, SoftStepReport& report, bool new_frames) {
    using Condensed = CondensedStep<Packing, Law>;
    Array<typename Condensed::Entry> entries;
    Array<Index> pair_of, wall_of;
    // As Newton's method converges, ever fewer open contacts can close.
    const double near =
        packing.mean_diameter() * std::clamp(3 * last_move_ / packing.mean_diameter(), 1e-5, 2e-3);
    const auto take = [&](const auto& set, double friction, auto& kept) {
      for (Index c = 0; c < set.size(); ++c)
        if (set.contact[c].gap < near || !set.reaction[c].isZero(0)) {
          entries.push_back({&set.contact[c], displacement(packing, set.contact[c]), friction});
          kept.push_back(c);
        }
    };
    take(pairs, law.friction, pair_of);
    take(walls, 0.0, wall_of);
    Array<Nodal> imbalance_of(packing.grains.size());
    for (Index g = 0; g < packing.grains.size(); ++g) imbalance_of[g] = imbalance(packing, g);
    definite_.resize(packing.grains.size());
    parallel_for(options.threads, packing.grains.size(), [&](Index g) {
      Nodal force;
      packing.grains[g].internal_force_and_definite_tangent(*packing.model, x_[g], force, definite_[g]);
      add_inertia(packing, g, definite_[g]);
    });
    condensed_.factorise(packing, definite_);
    const auto problem =
        condensed_.problem(packing, packing.model->boundary.samples, entries, imbalance_of, law);
    Eigen::VectorXd r(N * entries.size());
    for (Index c = 0; c < entries.size(); ++c) {
      const Vector<Dim> force =
          c < pair_of.size() ? pairs.force(pair_of[c]) : walls.force(wall_of[c - pair_of.size()]);
      r.template segment<N>(N * c) = Condensed::rows(*entries[c].contact) * force;
    }
    Solver solver;
    solver.stop.tolerance = options.contact_tolerance;
    solver.stop.max_sweeps = options.contact_sweeps;
    // What counts is the residual that the step itself is judged by: measured with the stiffness of the
    // surface, not with that of the whole grain, and relative to the reactions, not to the open gaps.
    Array<double> stiffness;
    for (const auto& entry : entries) stiffness.push_back(contact_stiffness(packing, *entry.contact));
    SolveReport solved;
    Index sweeps = 0;
    solver.stop.tolerance = options.contact_tolerance;
    Eigen::VectorXd u;
    double left = 0;
    const double target =
        std::clamp(0.03 * residual_norm_ / force_scale_, 0.2 * options.tolerance, options.contact_tolerance);
    for (int k = 0; k < 5; ++k) {
      solved = solver.solve(problem, r);
      sweeps += solved.sweeps;
      contact_velocity(problem, r, u);
      left = 0;
      for (Index c = 0; c < entries.size(); ++c)
        left += natural_map<N>(problem.law[c], ContactVector<N>(r.template segment<N>(N * c)),
                               ContactVector<N>(u.template segment<N>(N * c)), stiffness[c])
                    .squaredNorm();
      left = std::sqrt(left) / std::max(r.norm(), least_force(packing));
      if (left <= target || !solved.converged || sweeps >= options.contact_sweeps) break;
      solver.stop.tolerance =
          std::max(1e-14, std::min(0.1 * solver.stop.tolerance, 0.5 * solved.residual * target / left));
    }
    solved.sweeps = sweeps;
    report.sweeps += solved.sweeps;
    ++report.condensed;
    for (Index c = 0; c < entries.size(); ++c) {
      const ContactVector<N> local = r.template segment<N>(N * c);
      if (c < pair_of.size()) {
        if constexpr (N == 1)
          pairs.reaction[pair_of[c]] = local;
        else
          pairs.reaction[pair_of[c]] = Condensed::rows(*entries[c].contact).transpose() * local;
      } else {
        walls.reaction[wall_of[c - pair_of.size()]][0] = local[0];
      }
    }
    Eigen::VectorXd dx;
    condensed_.motion(r, dx);
    const auto start = x_;
    for (double length = longest(packing, dx); length > 1e-3; length *= 0.5) {
      if (!move(packing, start, length, dx)) continue;
      evaluate(packing);
      // The tangents are not exact and neither are frames: what converges slowly for that is accelerated.
      if (length == 1 && residual_norm_ <= 0.01 * force_scale_ && !balanced(options.tolerance)) {
        const Eigen::VectorXd step = mixing_.step(flat(start), dx);
        if (!(longest(packing, step) == 1 && move(packing, start, 1, step))) move(packing, start, 1, dx);
      } else {
        mixing_.forget();
      }
      if (new_frames) refresh(packing);
      evaluate(packing);
      has_factor_ = false;
      return true;
    }
    return false;
  }

  /// All unknowns, grain by grain.
  static Eigen::VectorXd flat(const Array<Nodal>& x) {
    const Index n = x[0].size();
    Eigen::VectorXd all(n * x.size());
    for (Index g = 0; g < x.size(); ++g)
      all.segment(n * g, n) = Eigen::Map<const Eigen::VectorXd>(x[g].data(), n);
    return all;
  }

  /// The longest step that moves no node by more than half an edge.
  double longest(const Packing& packing, const Eigen::VectorXd& dx) const {
    const double edge = packing.model->boundary.edge_length * packing.mean_diameter();
    return std::min(1.0,
                    0.5 * edge / std::max(dx.lpNorm<Eigen::Infinity>(), std::numeric_limits<double>::min()));
  }

  /// x_ = start + length dx; false when a cell is inverted there.
  bool move(const Packing& packing, const Array<Nodal>& start, double length, const Eigen::VectorXd& dx) {
    const Index n = Dim * packing.n_nodes();
    last_move_ = length * dx.lpNorm<Eigen::Infinity>();
    for (Index g = 0; g < packing.grains.size(); ++g)
      x_[g] = start[g] + length * Eigen::Map<const Nodal>(dx.data() + n * g, Dim, packing.n_nodes());
    return internal_forces(packing);
  }

  double h_ = 0;
  double last_move_ = 0;  ///< largest displacement of a node in the last iteration
  double penalty_ = 0, round_off_ = 0;
  Array<Nodal> x_, detected_at_, force_, old_force_, residual_, contact_nodal_, update_nodal_;
  Array<GrainSurface<Dim>> surfaces_;
  Array<ContactVector<N>> trial_pairs_;
  Array<ContactVector<1>> trial_walls_;
  NewtonSystem<Packing> system_;
  Anderson mixing_;  ///< of condensed iterations
  Array<BlockMatrix<Dim>> definite_;
  CondensedStep<Packing, Law> condensed_;
  bool has_factor_ = false;
  Index last_linear_ = 0, fresh_linear_ = 0;
  double residual_norm_ = 0, force_scale_ = 0, contact_residual_ = 0;
};

}  // namespace jampack
