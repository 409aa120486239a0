// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/solver/alart_curnier.hpp>
#include <jampack/solver/gmres.hpp>
#include <jampack/solver/grain_newton_matrix.hpp>
#include <jampack/stepping/augmented_balance.hpp>
#include <jampack/stepping/condensed_contacts.hpp>
#include <jampack/stepping/contact_spread.hpp>
#include <optional>
#include <utility>

namespace jampack {

/// Newton's method on balance and contact law at once (docs/theory/deformable_stage.md, section 7):
///   T dx - H^T dr = -R,   A (H dx + D dr) + C dr = b.
/// Near the end T are the exact tangents and D, a multiple of the compliance of the surface, is there for
/// contacts that are redundant only; far from it T is stiffened towards its definite stand-in, and D grows.
/// By GMRES, preconditioned by the stand-ins and the contact problem condensed with them. That may be an
/// earlier one, with other frames and contacts: those it does not know are reckoned with one by one.
template <class Packing, ContactLaw Law>
class CoupledNewton {
 public:
  static constexpr int Dim = Packing::dimension;
  using Step = CondensedStep<Packing, Law>;
  static constexpr int N = Step::N;
  using Condensed = CondensedContacts<typename Step::Problem>;
  using Nodal = typename Packing::Nodal;
  using Vec = ContactVector<N>;
  using Block = Eigen::Matrix<double, N, N>;

  /// `condensed` is the problem that `step` was last asked for; neither may change while this is in use.
  CoupledNewton(const Step& step, const Condensed& condensed, Threads threads)
      : step_(step), condensed_(condensed), threads_(threads), matrix_(condensed.problem.delassus, threads) {}

  /// Steps from where `balance` stands as long as they lead nearer to the end, by distance(balance), which is
  /// at most 1 there; none may move a node farther than `longest`. They may lead away for a while: states of
  /// contacts are changed in every one. Leaves `balance` and `watched` at the best point, the cells
  /// linearised there, and returns how far that is for a node; or nothing, being back at the
  /// start, its forces cut to their cones, where no point was better, or its potential was not lower by all
  /// but `round_off`.
  template <class Distance, class Watched>
  std::optional<double> run(const Packing& packing, double longest, double round_off, Distance distance,
                            AugmentedBalance<Packing, Law>& balance, Watched& watched) {
    constexpr int max_steps = 40, patience = 10;
    constexpr double gain = 0.5;  // less is none
    constexpr double far = 1e3;   // from the end, where steps begin with most caution
    balance.accept_forces(watched);
    struct Point {
      Array<Nodal> x;
      Array<ContactVector<N>> pair_force;
      Array<ContactVector<1>> wall_force;
    };
    const auto here = [&] { return Point{balance.x, watched.pairs.reaction, watched.walls.reaction}; };
    const auto go_to = [&](const Point& point) {
      balance.x = point.x;
      watched.pairs.reaction = point.pair_force;
      watched.walls.reaction = point.wall_force;
    };
    const Point start = here();
    Point best = start;
    const double first = distance(balance);
    const double lost = std::max(first, std::min(100 * first, 1e5));  // from there no way leads back
    double least = first, last = first, mark = first;
    definite_ = std::min(1.0, first / far);
    proximal_ = std::max(least_proximal, first_proximal * definite_);
    bool gained = false;
    Eigen::VectorXd dx;
    if (!balance.linearise_exactly(packing, tangent_)) return {};
    for (int k = 0, worse = 0; k < max_steps && least > 1 && worse < patience; ++k) {
      if (!step(packing, balance, watched, dx)) break;
      if (!(dx.lpNorm<Eigen::Infinity>() <= longest)) break;
      for (Index g = 0; g < n_grains_; ++g)
        balance.x[g] += Eigen::Map<const Nodal>(dx.data() + n_nodal_ * g, Dim, packing.n_nodes());
      if (!balance.linearise_exactly(packing, tangent_)) break;
      balance.evaluate(packing, watched);
      const double now = distance(balance);
      adapt(now / std::exchange(last, now));
      if (now > lost) break;
      if (now < least) {
        best = here();
        least = now;
        gained = true;
      }
      worse = now < gain * mark ? 0 : worse + 1;
      if (worse == 0) mark = now;
    }
    go_to(best);
    std::optional<double> moved;
    if (gained) {
      // The nearest solution may be one that the packing would leave.
      balance.hold_bounds(watched, watched.pairs.reaction);
      const double there = balance.potential(packing, watched);
      balance.x = start.x;
      if (there <= balance.potential(packing, watched) + round_off) {
        balance.x = best.x;
        moved = 0;
        for (Index g = 0; g < n_grains_; ++g)
          moved = std::max(*moved, (best.x[g] - start.x[g]).template lpNorm<Eigen::Infinity>());
      } else {
        go_to(start);
      }
    }
    balance.linearise(packing);
    balance.evaluate(packing, watched);
    return moved;
  }

 private:
  static constexpr double first_proximal = 1e-2, least_proximal = 1e-4;

  /// A step has changed the distance from the end by this factor: those that lead there need less caution.
  void adapt(double change) {
    if (change < 1) definite_ *= 0.3;
    if (change > 2) definite_ = std::min(2 * definite_, 1.0);
    proximal_ = std::clamp((change < 0.5 ? 0.1 : change > 2 ? 4 : 0.5) * proximal_, least_proximal, 1.0);
  }

  /// One step from where `balance` stands, `watched` having the forces to start from: they become the next
  /// ones, dx is the motion. False, with nothing changed, if it was not found.
  template <class Watched>
  bool step(const Packing& packing, const AugmentedBalance<Packing, Law>& balance, Watched& watched,
            Eigen::VectorXd& dx) {
    constexpr double enough = 0.02;  // of the right-hand side may be left
    constexpr double useless = 0.5;  // a step that leaves more
    constexpr Index max_iterations = 60;
    n_grains_ = packing.grains.size();
    n_nodal_ = Dim * packing.n_nodes();
    for (Index g = 0; definite_ > 0 && g < n_grains_; ++g)
      for (Index k = 0; k < tangent_[g].block.size(); ++k)
        tangent_[g].block[k] += definite_ * (balance.tangent[g].block[k] - tangent_[g].block[k]);
    linearise(packing, balance, watched);
    if (!prepare()) return false;
    const Index n_motions = n_nodal_ * n_grains_;
    Eigen::VectorXd z(n_motions + N * active_.size());
    Array<Nodal> forces(n_grains_, Nodal::Zero(Dim, packing.n_nodes()));
    watched.scatter(watched.pairs.reaction, watched.walls.reaction, forces);
    parallel_for(threads_, n_grains_, [&](Index g) {
      const Nodal left = forces[g] - balance.imbalance(packing, g);
      z.segment(n_nodal_ * g, n_nodal_) = Eigen::Map<const Eigen::VectorXd>(left.data(), n_nodal_);
    });
    for (const auto& [grain, node, force] : gone_)
      z.template segment<Dim>(n_nodal_ * grain + Dim * node) -= force;
    for (Index c = 0; c < active_.size(); ++c)
      z.template segment<N>(n_motions + N * c) = active_[c].stiffness * active_[c].row.kept(active_[c].row.b);
    const double left = gmres([&](const Eigen::VectorXd& v, Eigen::VectorXd& out) { apply(packing, v, out); },
                              [&](Eigen::VectorXd& v) { precondition(v); }, z, enough, max_iterations);
    if (!(left <= useless) || !z.allFinite()) return false;
    dx = z.head(n_motions);
    for (auto& r : watched.pairs.reaction) r.setZero();
    for (auto& r : watched.walls.reaction) r.setZero();
    for (Index c = 0; c < active_.size(); ++c) {
      const auto& active = active_[c];
      const Vec r = active.row.kept(active.reaction + z.template segment<N>(n_motions + N * c));
      set_force(watched, active.is_wall, active.index, r);
    }
    return true;
  }

  /// A contact that takes part.
  struct Active {
    bool is_wall;
    Index index;       ///< among the watched ones
    Index place;       ///< in the condensed problem; -1 if it is not there
    double stiffness;  ///< of the surface
    Vec reaction;      ///< in its local axes
    AlartCurnierRow<N> row;
  };
  /// A force on a node that goes, its contact being open.
  struct Gone {
    Index grain, node;
    Vector<Dim> force;
  };

  /// Which contacts take part, and their rows.
  template <class Watched>
  void linearise(const Packing& packing, const AugmentedBalance<Packing, Law>& balance,
                 const Watched& watched) {
    active_.clear();
    gone_.clear();
    spread_ = ContactSpread<Dim, N>(n_grains_);
    const auto visit = [&](const auto& set, const typename Law::Contact& law, bool is_wall) {
      for (Index k = 0; k < set.size(); ++k) {
        const auto& contact = set.contact[k];
        const bool carries = !set.reaction[k].isZero(0);
        if (!carries && contact.gap > 0) continue;
        const auto axes = Step::rows(contact);
        const double stiffness = balance.contact_stiffness(packing, contact);
        const Vec r = axes * set.force(k), u = axes * watched.displacement(packing, contact, balance.x);
        auto row = alart_curnier_row<N>(law, r, u, stiffness);
        const Vec lost = r - row.kept(r);
        if (!lost.isZero(0))
          contact.for_each_node([&](Index grain, Index node, double weight) {
            gone_.push_back({grain, node, weight * (axes.transpose() * lost)});
          });
        if (row.n_rows == 0) continue;
        row.c += proximal_ / stiffness * row.a;
        spread_.add(contact, active_.size(), axes);
        active_.push_back({is_wall, k, condensed_.place(contact), stiffness, r, row});
      }
    };
    visit(watched.pairs, balance.law, false);
    visit(watched.walls, typename Law::Contact{}, true);
  }

  /// Sets up the preconditioner.
  bool prepare() {
    const Index n = condensed_.problem.n_contacts();
    Array<int> n_rows(n, 0);
    Array<Block> a(n, Block::Identity()), c(n, Block::Zero());
    alone_.assign(active_.size(), Block::Identity());
    for (Index k = 0; k < active_.size(); ++k) {
      const auto& [is_wall, index, place, stiffness, reaction, row] = active_[k];
      if (place >= 0) {
        n_rows[place] = row.n_rows;
        a[place] = row.a;
        c[place] = row.c;
      } else {
        Block own = row.a / stiffness + row.c;
        for (int i = row.n_rows; i < N; ++i) own.row(i) = Block::Identity().row(i);
        alone_[k] = own.inverse();
      }
    }
    return matrix_.prepare(n_rows, a, c);
  }

  /// H dx of the active contacts.
  template <class Moved>
  Eigen::VectorXd relative(const Moved& moved) const {
    Eigen::VectorXd u = Eigen::VectorXd::Zero(N * active_.size());
    spread_.add_motion(moved, u);
    return u;
  }

  // Rows of the law are scaled to forces; unknowns that are gone stay zero.
  void apply(const Packing& packing, const Eigen::VectorXd& z, Eigen::VectorXd& out) const {
    const Index n_motions = n_nodal_ * n_grains_;
    const auto force = z.tail(N * active_.size());
    out.resize(z.size());
    parallel_for(threads_, n_grains_, [&](Index g) {
      Eigen::VectorXd own = Eigen::VectorXd::Zero(n_nodal_);
      tangent_[g].add_product(packing.model->pattern, z.data() + n_nodal_ * g, own.data());
      spread_.add_pull(g, force, -1, own);
      out.segment(n_nodal_ * g, n_nodal_) = own;
    });
    const Eigen::VectorXd u = relative([&](Index g) { return z.segment(n_nodal_ * g, n_nodal_); });
    for (Index c = 0; c < active_.size(); ++c) {
      const auto& row = active_[c].row;
      const Vec v = row.a * u.template segment<N>(N * c) + row.c * force.template segment<N>(N * c);
      out.template segment<N>(n_motions + N * c) = active_[c].stiffness * row.kept(v);
    }
  }

  void precondition(Eigen::VectorXd& z) const {
    const Index n_motions = n_nodal_ * n_grains_;
    Array<Eigen::VectorXd> moved(n_grains_);
    parallel_for(threads_, n_grains_,
                 [&](Index g) { moved[g] = step_.solve(g, z.segment(n_nodal_ * g, n_nodal_)); });
    Eigen::VectorXd force = relative([&](Index g) -> const Eigen::VectorXd& { return moved[g]; });
    Eigen::VectorXd known = Eigen::VectorXd::Zero(N * condensed_.problem.n_contacts());
    for (Index c = 0; c < active_.size(); ++c) {
      const auto& active = active_[c];
      auto own = force.template segment<N>(N * c);
      const Vec v = z.template segment<N>(n_motions + N * c) / active.stiffness - active.row.a * own;
      own = active.row.kept(v);
      if (active.place >= 0)
        known.template segment<N>(N * active.place) = own;
      else
        own = (alone_[c] * own).eval();
    }
    matrix_.precondition(known);
    for (Index c = 0; c < active_.size(); ++c)
      if (active_[c].place >= 0)
        force.template segment<N>(N * c) = known.template segment<N>(N * active_[c].place);
    parallel_for(threads_, n_grains_, [&](Index g) {
      Eigen::VectorXd load = z.segment(n_nodal_ * g, n_nodal_);
      spread_.add_pull(g, force, 1, load);
      z.segment(n_nodal_ * g, n_nodal_) = step_.solve(g, load);
    });
    z.tail(force.size()) = force;
  }

  const Step& step_;
  const Condensed& condensed_;
  Threads threads_;
  NewtonMatrix<GrainComplianceDelassus<N>> matrix_;
  Index n_grains_ = 0, n_nodal_ = 0;
  double definite_ = 0;              ///< share of the stand-ins in T
  double proximal_ = 0;              ///< D, in units of the compliance of the surface
  Array<BlockMatrix<Dim>> tangent_;  ///< T, the stand-ins blended in by step()
  Array<Active> active_;
  Array<Gone> gone_;
  ContactSpread<Dim, N> spread_;  ///< of the active contacts
  Array<Block> alone_;            ///< inverses, for those that the condensed problem does not know
};

}  // namespace jampack
