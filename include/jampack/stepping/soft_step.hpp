// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <jampack/detection/surface_detection.hpp>
#include <jampack/geometry/frame.hpp>
#include <jampack/law/signorini.hpp>
#include <jampack/problem/residual.hpp>
#include <jampack/solver/gmres.hpp>
#include <jampack/stepping/newton_system.hpp>

namespace jampack {

/// How one implicit step is solved. docs/results/compaction.md says how the defaults came about.
struct SoftStepOptions {
  double theta = 1;         ///< of the Moreau-Jean scheme, in [0.5, 1]
  double tolerance = 3e-7;  ///< on the equilibrium residual and on the scaled contact residual
  int max_iterations = 40;  ///< Newton iterations before the step is given up
  double penalty = 10;      ///< augmentation, in units of the stiffness of a surface layer one edge thick
  int hardening = 12;       ///< iterations after which the penalty grows
  double linear_tolerance = 0.05;  ///< of the inner linear solves, relative
  double reach = 0.03;             ///< detection distance over the mean diameter
  Threads threads;
};

/// What one step cost and reached.
struct SoftStepReport {
  bool converged = false;
  int iterations = 0;
  Index linear_iterations = 0;
  double equilibrium_residual = 0;  ///< |M dv - h (f_ext - f_int) - H^T r| / |H^T r|, the step's own frames
  double scaled_residual = 0;
  std::string reason;  ///< why it failed
};

/// One implicit Moreau-Jean step of a packing of deformable grains under exact contact: Newton on internal
/// forces and contact together, contact forces by the augmented Lagrangian (docs/theory/deformable_stage.md).
template <class Packing, ContactLaw Law>
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
    auto report = solve(packing, h);
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
  SoftStepReport solve(Packing& packing, double h) {
    SoftStepReport report;
    const Index n_grains = packing.grains.size();
    h_ = h;
    x_.resize(n_grains);
    force_.resize(n_grains);
    old_force_.resize(n_grains);
    residual_.resize(n_grains);
    surfaces_.resize(n_grains);
    system_.threads = options.threads;
    system_.resize(packing);
    for (Index g = 0; g < n_grains; ++g) {
      const auto& grain = packing.grains[g];
      x_[g] = grain.position + h * grain.velocity;
      if (options.theta < 1) grain.internal_force(*packing.model, grain.position, old_force_[g]);
    }
    if (!internal_forces(packing)) {
      // The extrapolated shapes are no use: start from those of the last step.
      for (Index g = 0; g < n_grains; ++g) x_[g] = packing.grains[g].position;
      if (!internal_forces(packing)) return fail(report, "a cell is inverted at the start of the step");
    }
    find_contacts(packing);
    contact_geometry(packing);
    bool fresh_factor = false;
    Index iterations_with_fresh_factor = 0;

    penalty_ = options.penalty;
    last_pairs_.clear();
    last_walls_.clear();
    contact_forces(packing);
    balance(packing);
    for (;; ++report.iterations) {
      report.equilibrium_residual = residual_norm_ / std::max(contact_norm_, tiny_);
      report.scaled_residual = contact_residual_;
      if (residual_norm_ <= options.tolerance * contact_norm_ + round_off(packing) &&
          contact_residual_ <= options.tolerance) {
        accept_forces();
        if (!find_contacts(packing)) {
          report.converged = true;
          return report;
        }
        contact_geometry(packing);
        contact_forces(packing);
        balance(packing);
        continue;
      }
      // The multipliers move only once balance at the old ones is ahead of the contact conditions.
      if (const double update = update_norm(packing); residual_norm_ <= 0.3 * update) {
        // Which contacts stick, slip or are open is found at a soft penalty; what then converges slowly
        // (stiff, redundant contacts) converges faster at a hard one.
        if (report.iterations >= options.hardening) penalty_ = std::min(3 * penalty_, 300 * options.penalty);
        move_multipliers(packing, update);
      }
      if (report.iterations == options.max_iterations)
        return fail(report, "Newton's method did not converge in " + std::to_string(options.max_iterations) +
                                " iterations");

      assemble_system(packing);
      if (!fresh_factor ||
          report.linear_iterations > last_linear_total_ + 2 * iterations_with_fresh_factor + 20) {
        system_.factorise();
        fresh_factor = true;
        last_linear_total_ = report.linear_iterations;
      }
      system_.coarsen(x_);
      const Index n = Dim * packing.n_nodes();
      Eigen::VectorXd rhs(n * n_grains), dx;
      for (Index g = 0; g < n_grains; ++g)
        rhs.segment(n * g, n) = -Eigen::Map<const Eigen::VectorXd>(residual_[g].data(), n);
      Gmres gmres;
      gmres.tolerance = options.linear_tolerance;
      const auto linear = gmres.solve([&](const auto& a, auto& b) { system_.apply(a, b); },
                                      [&](const auto& a, auto& b) { system_.precondition(a, b); }, rhs, dx);
      report.linear_iterations += linear.iterations;
      if (iterations_with_fresh_factor == 0) iterations_with_fresh_factor = linear.iterations;
      last_linear_total_ = report.linear_iterations - linear.iterations;
      if (!dx.allFinite()) return fail(report, "the linear solve broke down");
      if (!line_search(packing, dx)) return fail(report, "no step length lowers the residual");
    }
  }

  static SoftStepReport fail(SoftStepReport report, std::string reason) {
    report.converged = false;
    report.reason = std::move(reason);
    return report;
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
    parallel_for(options.threads, packing.grains.size(),
                 [&](Index g) { surfaces_[g].update(packing.model->boundary, x_[g]); });
  }

  /// Gaps, normals and weights of the watched contacts at x_.
  void contact_geometry(const Packing& packing) {
    update_surfaces(packing);
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
    for (auto& contact : walls.contact)
      contact.gap = packing.room.gap(contact.wall(), surfaces_[contact.candidate].sample_point(
                                                         samples[contact.sample], x_[contact.candidate]));
  }

  /// What resists a force at one sample in a step: a surface layer one edge thick under the sample's area,
  /// and the mass of a node. About N / tr W_cc, so that the contact residual measured with it is the scaled
  /// one.
  double contact_stiffness(const Packing& packing, const SurfaceContact<Dim>& contact) const {
    const auto& boundary = packing.model->boundary;
    const auto& grain = packing.grains[contact.candidate];
    const double size = Dim == 2 ? 1.0 : grain.diameter;
    const double layer =
        8 * packing.model->material.young * boundary.sample_area / boundary.edge_length * size;
    return layer + grain.mass.mean() / (options.theta * h_ * h_);
  }
  double penalty(const Packing& packing, const SurfaceContact<Dim>& contact) const {
    return penalty_ * contact_stiffness(packing, contact);
  }

  /// Displacement of a contact in the step: gap along the normal, slip across it (eq. 5).
  Vector<Dim> contact_displacement(const Packing& packing, const SurfaceContact<Dim>& contact) const {
    const auto& sample = packing.model->boundary.samples[contact.sample];
    const auto& grain = packing.grains[contact.candidate];
    const auto& other = packing.grains[contact.antagonist];
    const auto& surface = surfaces_[contact.candidate];
    const Vector<Dim> relative =
        surface.sample_point(sample, x_[contact.candidate]) - surface.sample_point(sample, grain.position) -
        contact.antagonist_point(x_[contact.antagonist]) + contact.antagonist_point(other.position);
    return relative + (contact.gap - contact.normal.dot(relative)) * contact.normal;
  }

  /// Trial forces P(lambda - rho s) (eq. 7) and the natural map of what they leave.
  void contact_forces(const Packing& packing) {
    trial_pairs_.resize(pairs.size());
    trial_walls_.resize(walls.size());
    double error = 0, size = 0;
    for (Index c = 0; c < pairs.size(); ++c) {
      const auto& contact = pairs.contact[c];
      const double rho = penalty(packing, contact);
      if constexpr (N == 1) {
        trial_pairs_[c][0] = std::max(0.0, pairs.reaction[c][0] - rho * contact.gap);
        error += natural_map<1>(law, trial_pairs_[c], ContactVector<1>(contact.gap),
                                contact_stiffness(packing, contact))
                     .squaredNorm();
      } else {
        const auto& normal = contact.normal;
        const Vector<Dim> s = contact_displacement(packing, contact);
        const Vector<Dim> trial = pairs.reaction[c] - rho * s;
        const double trial_normal = normal.dot(trial);
        if (trial_normal <= 0) {
          trial_pairs_[c].setZero();
        } else {
          Vector<Dim> tangential = trial - trial_normal * normal;
          const double length = tangential.norm(), bound = law.friction * trial_normal;
          if (length > bound) tangential *= bound / length;
          trial_pairs_[c] = trial_normal * normal + tangential;
        }
        const auto frame = contact_frame<Dim>(normal);
        error += natural_map<N>(law, ContactVector<N>(frame * trial_pairs_[c]), ContactVector<N>(frame * s),
                                contact_stiffness(packing, contact))
                     .squaredNorm();
      }
      size += trial_pairs_[c].squaredNorm();
    }
    for (Index c = 0; c < walls.size(); ++c) {
      const auto& contact = walls.contact[c];
      const double rho = penalty(packing, contact);
      trial_walls_[c][0] = std::max(0.0, walls.reaction[c][0] - rho * contact.gap);
      error += natural_map<1>(Signorini{}, trial_walls_[c], ContactVector<1>(contact.gap),
                              contact_stiffness(packing, contact))
                   .squaredNorm();
      size += trial_walls_[c].squaredNorm();
    }
    contact_residual_ = size > 0 ? std::sqrt(error / size) : std::sqrt(error);
  }

  /// Adds `sign` times the nodal forces of one contact to `nodal`.
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

  /// Residual of the balance of momentum, as forces (eq. 6).
  void balance(const Packing& packing) {
    const Index n_grains = packing.grains.size();
    contact_nodal_.resize(n_grains);
    update_nodal_.resize(n_grains);
    for (Index g = 0; g < n_grains; ++g) contact_nodal_[g].setZero(Dim, packing.n_nodes());
    scatter_all(packing, pairs, trial_pairs_, contact_nodal_);
    scatter_all(packing, walls, trial_walls_, contact_nodal_);
    double error = 0, size = 0;
    for (Index g = 0; g < n_grains; ++g) {
      const auto& grain = packing.grains[g];
      const Nodal dv = ((x_[g] - grain.position) / h_ - grain.velocity) / options.theta;
      residual_[g] = dv * (grain.mass / h_).asDiagonal() + options.theta * force_[g] - contact_nodal_[g];
      if (options.theta < 1) residual_[g] += (1 - options.theta) * old_force_[g];
      error += residual_[g].squaredNorm();
      size += contact_nodal_[g].squaredNorm();
    }
    residual_norm_ = std::sqrt(error);
    contact_norm_ = std::sqrt(size);
  }

  void accept_forces() {
    pairs.reaction = trial_pairs_;
    walls.reaction = trial_walls_;
  }

  /// Moves the multipliers to the trial forces. Updates that follow one another along one line shrink by a
  /// constant ratio (not at all where redundant contacts pass their forces to each other): the sum of what is
  /// to come is taken at once, as far as the first contact that it unloads (Aitken's extrapolation).
  void move_multipliers(const Packing& packing, double update) {
    double along = 0, now = 0, before = 0;
    double reach = update > 0 ? 0.01 * contact_norm_ / update : 0;
    auto compare = [&](const auto& set, const auto& trial, auto& last, const auto& normal_part) {
      if (last.size() != set.size()) last.assign(set.size(), std::decay_t<decltype(last[0])>::Zero());
      for (Index c = 0; c < set.size(); ++c) {
        const auto step = (trial[c] - set.reaction[c]).eval();
        along += step.dot(last[c]);
        now += step.squaredNorm();
        before += last[c].squaredNorm();
        if (const double fall = -normal_part(c, step); fall > 0)
          reach = std::min(reach, normal_part(c, trial[c]) / fall);
        last[c] = step;
      }
    };
    compare(pairs, trial_pairs_, last_pairs_, [&](Index c, const ContactVector<N>& r) {
      if constexpr (N == 1)
        return r[0];
      else
        return pairs.contact[c].normal.dot(r);
    });
    compare(walls, trial_walls_, last_walls_, [](Index, const ContactVector<1>& r) { return r[0]; });
    accept_forces();
    const double ratio = along / std::max(before, tiny_);
    if (ratio < 1) reach = std::min(reach, ratio / (1 - ratio));
    if (contact_residual_ < 1e-3 && ratio > 0.3 && along > 0.97 * std::sqrt(now * before)) {
      for (Index c = 0; c < pairs.size(); ++c) pairs.reaction[c] += reach * last_pairs_[c];
      for (Index c = 0; c < walls.size(); ++c) walls.reaction[c] += reach * last_walls_[c];
      last_pairs_.clear();
      last_walls_.clear();
    }
    contact_forces(packing);
    balance(packing);
  }

  /// Force that a change of the multipliers to the trial forces would make.
  double update_norm(const Packing& packing) {
    for (auto& f : update_nodal_) f.setZero(Dim, packing.n_nodes());
    for (Index c = 0; c < pairs.size(); ++c) {
      const ContactVector<N> change = trial_pairs_[c] - pairs.reaction[c];
      if (!change.isZero(0)) scatter(packing, pairs.contact[c], pairs.force(c, change), update_nodal_);
    }
    for (Index c = 0; c < walls.size(); ++c) {
      const ContactVector<1> change = trial_walls_[c] - walls.reaction[c];
      if (!change.isZero(0)) scatter(packing, walls.contact[c], walls.force(c, change), update_nodal_);
    }
    double sum = 0;
    for (const auto& f : update_nodal_) sum += f.squaredNorm();
    return std::sqrt(sum);
  }

  void assemble_system(const Packing& packing) {
    const auto& pattern = packing.model->pattern;
    const auto& samples = packing.model->boundary.samples;
    parallel_for(options.threads, packing.grains.size(), [&](Index g) {
      auto& tangent = system_.tangent[g];
      if (options.theta != 1)
        for (auto& block : tangent.block) block *= options.theta;
      const double factor = 1 / (options.theta * h_ * h_);
      for (Index i = 0; i < pattern.n_rows(); ++i)
        tangent.block[pattern.position(i, i)].diagonal().array() += factor * packing.grains[g].mass[i];
    });
    system_.couplings.clear();
    for (Index c = 0; c < pairs.size(); ++c) {
      const auto& contact = pairs.contact[c];
      const double rho = penalty(packing, contact);
      const auto& n = contact.normal;
      const auto& m = contact.tangents.gap_gradient;
      const Matrix<Dim> nn = rho * n * n.transpose();
      if constexpr (N == 1) {
        const double trial = pairs.reaction[c][0] - rho * contact.gap;
        if (trial > 0)
          system_.add(samples[contact.sample], contact, Matrix<Dim>(rho * n * m.transpose()), nn, trial * n,
                      trial * Matrix<Dim>::Identity());
      } else {
        const Vector<Dim> trial = pairs.reaction[c] - rho * contact_displacement(packing, contact);
        const double trial_normal = n.dot(trial);
        if (trial_normal <= 0) continue;
        const Vector<Dim> tangential = trial - trial_normal * n;
        const double length = tangential.norm(), bound = law.friction * trial_normal;
        const Matrix<Dim> across = rho * Matrix<Dim>::Identity() - nn;
        if (length <= bound) {
          const Matrix<Dim> stick = across + rho * n * m.transpose();
          system_.add(samples[contact.sample], contact, stick, Matrix<Dim>(nn + across), trial,
                      Matrix<Dim>::Zero());
        } else {
          const Vector<Dim> t = tangential / length;
          const Matrix<Dim> definite = nn + bound / length * (across - rho * t * t.transpose());
          // A stuck contact keeps its force while the normal turns; a slipping one turns with it (eq. 10).
          const Matrix<Dim> off_slip = Matrix<Dim>::Identity() - t * t.transpose();
          const Vector<Dim>& kept = trial;
          const Matrix<Dim> turn = (n + law.friction * t) * pairs.reaction[c].transpose() +
                                   trial_normal * Matrix<Dim>::Identity() -
                                   bound / length * (trial_normal * off_slip + n * kept.transpose());
          system_.add(samples[contact.sample], contact,
                      Matrix<Dim>(definite - nn + rho * (n + law.friction * t) * m.transpose()), definite,
                      Vector<Dim>(trial_normal * n + bound * t), turn);
        }
      }
    }
    for (Index c = 0; c < walls.size(); ++c) {
      const auto& contact = walls.contact[c];
      const double rho = penalty(packing, contact);
      if (walls.reaction[c][0] - rho * contact.gap <= 0) continue;
      const Matrix<Dim> nn = rho * contact.normal * contact.normal.transpose();
      system_.add(samples[contact.sample], contact, nn, nn, Vector<Dim>::Zero(), Matrix<Dim>::Zero());
    }
    system_.finish();
  }

  /// Where along dx a slipping contact first comes to rest before it would slip the other way: the middle of
  /// the narrow stretch on which it sticks. Past it the linearisation, which knows no rest, goes astray.
  double first_rest(const Packing& packing, const Eigen::VectorXd& dx) const {
    double first = 1;
    if constexpr (N > 1) {
      const Index n = Dim * packing.n_nodes();
      const auto& samples = packing.model->boundary.samples;
      for (Index c = 0; c < pairs.size(); ++c) {
        const auto& contact = pairs.contact[c];
        const auto& normal = contact.normal;
        const double rho = penalty(packing, contact);
        const Vector<Dim> trial = pairs.reaction[c] - rho * contact_displacement(packing, contact);
        const double trial_normal = normal.dot(trial);
        const Vector<Dim> tangential = trial - trial_normal * normal;
        const double length = tangential.norm();
        if (trial_normal <= 0 || length <= law.friction * trial_normal) continue;
        Vector<Dim> move = Vector<Dim>::Zero();
        const auto& sample = samples[contact.sample];
        for (Index i = 0; i < sample.n; ++i)
          move += sample.weight[i] *
                  dx.template segment<Dim>(n * contact.candidate + Dim * sample.node[std::size_t(i)]);
        for (Index i = 0; i < contact.n_nodes; ++i)
          move -= contact.weight[i] *
                  dx.template segment<Dim>(n * contact.antagonist + Dim * contact.node[std::size_t(i)]);
        const double fall = rho * move.dot(tangential) / length;
        if (fall > length) first = std::min(first, length / fall);
      }
    }
    return first;
  }

  /// Moves x_ along dx, shortened until no cell is inverted and the residual at fixed multipliers does not
  /// falls; where it does not fall at any, the
  /// length that leaves the least of it is taken, for the next linearisation to do better.
  bool line_search(const Packing& packing, const Eigen::VectorXd& dx) {
    const Index n_grains = packing.grains.size(), n = Dim * packing.n_nodes();
    const auto start = x_;
    const double before = residual_norm_;
    const double edge = packing.model->boundary.edge_length * packing.mean_diameter();
    double length = std::min(1.0, 0.5 * edge / std::max(dx.lpNorm<Eigen::Infinity>(), tiny_));
    double best = std::numeric_limits<double>::infinity(), best_length = 0;
    auto go = [&](double along) {
      for (Index g = 0; g < n_grains; ++g)
        x_[g] = start[g] + along * Eigen::Map<const Nodal>(dx.data() + n * g, Dim, packing.n_nodes());
      if (!internal_forces(packing)) return false;
      contact_geometry(packing);
      contact_forces(packing);
      balance(packing);
      return true;
    };
    const double rest = first_rest(packing, dx);
    for (int cut = 0; cut < 6 || best_length == 0;
         ++cut, length = cut == 1 && rest < length ? rest : 0.5 * length) {
      if (cut == 30) return false;
      if (!go(length)) continue;
      if (residual_norm_ <= (1 - 0.05 * length) * before) return true;
      if (residual_norm_ < best) {
        best = residual_norm_;
        best_length = length;
      }
    }
    go(best_length);
    return true;
  }

  /// Forces that round-off alone leaves: nothing can be balanced better.
  static double round_off(const Packing& packing) {
    const double d = packing.mean_diameter();
    return 1e-13 * packing.model->material.young * (Dim == 2 ? d : d * d);
  }

  static constexpr double tiny_ = std::numeric_limits<double>::min();

  double h_ = 0;
  double penalty_ = 0;
  Array<Nodal> x_, force_, old_force_, residual_, contact_nodal_, update_nodal_;
  Array<GrainSurface<Dim>> surfaces_;
  Array<ContactVector<N>> trial_pairs_;
  Array<ContactVector<1>> trial_walls_;
  Array<ContactVector<N>> last_pairs_;  ///< last change of the multipliers
  Array<ContactVector<1>> last_walls_;
  NewtonSystem<Packing> system_;
  double residual_norm_ = 0, contact_norm_ = 0, contact_residual_ = 0;
  Index last_linear_total_ = 0;
};

}  // namespace jampack
