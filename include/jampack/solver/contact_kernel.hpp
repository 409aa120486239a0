// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <jampack/core/unroll.hpp>
#include <jampack/problem/rigid_balls_delassus.hpp>
#include <jampack/problem/rows_times.hpp>
#include <jampack/solver/local_solver.hpp>
#include <type_traits>
#include <utility>

namespace jampack {

/// One contact update of Gauss–Seidel, for any Delassus operator: its velocity, the exact local solution, the
/// change of motion. Set up once for a problem, which it refers to; visit() allocates nothing.
template <class Problem>
class ContactKernel {
  static constexpr int N = Problem::n_unknowns;
  using Delassus = typename Problem::DelassusType;
  using Block = std::remove_cvref_t<decltype(std::declval<const Delassus&>().diagonal_block(Index{}))>;

 public:
  ContactKernel(const Problem& problem, const Eigen::VectorXd& r)
      : problem_(problem), motion_(problem.delassus.motion(r)) {
    record_.reserve(problem.n_contacts());
    for (Index c = 0; c < problem.n_contacts(); ++c) {
      Record record{LocalSolver<N, Block>(problem.delassus.diagonal_block(c)), problem.law[c], {}, c};
      for (int i = 0; i < N; ++i)
        record.free_velocity[static_cast<std::size_t>(i)] = problem.free_velocity[N * c + i];
      record_.push_back(record);
    }
  }

  /// To be called when r was changed from outside.
  void restart(const Eigen::VectorXd& r) { motion_ = problem_.delassus.motion(r); }

  /// Gives the contacts places in memory: the k-th place to order[k]. Until then contact c has place c.
  void arrange(const Array<Index>& order) {
    Array<Record> arranged(record_.size());
    for (const Record& record : record_) arranged[record.contact] = record;
    for (Index k = 0; k < order.size(); ++k) record_[k] = arranged[order[k]];
  }

  /// Updates the contacts at the places from `first` to before `last`, in that order; returns the sum of
  /// |dr_c|^2.
  double visit(const Index* first, const Index* last, Eigen::VectorXd& r, double relaxation) {
    double changed = 0;
    for (; first != last; ++first) changed += update(record_[*first], r, relaxation);
    return changed;
  }

 private:
  /// What an update reads of a contact besides its row of W: together, as every array more is one stream
  /// more that the processor has to fetch ahead.
  struct Record {
    LocalSolver<N, Block> local;
    typename Problem::LocalLaw law;
    std::array<double, N> free_velocity;
    Index contact;
  };

  [[gnu::always_inline]] double update(const Record& record, Eigen::VectorXd& r, double relaxation) {
    const Index c = record.contact;
    ContactVector<N> old, u = problem_.delassus.velocity(motion_, r, c);
    unroll<N>([&](int i) {
      old[i] = r[N * c + i];
      u[i] += record.free_velocity[static_cast<std::size_t>(i)];
    });
    ContactVector<N> next = record.local.solve(record.law, u, old);
    if (relaxation != 1) {
      const ContactVector<N> other = relaxed(next, old, record.law.friction, relaxation);
      unroll<N>([&](int i) { next[i] = other[i]; });
    }
    ContactVector<N> dr;
    double changed = 0;
    unroll<N>([&](int i) {
      dr[i] = next[i] - old[i];
      changed += dr[i] * dr[i];
      r[N * c + i] = next[i];
    });
    // Where nothing but r is kept up to date, asking costs more than it saves: the answer cannot be foreseen.
    if (!std::is_empty_v<typename Delassus::Motion> && changed == 0) return 0;
    problem_.delassus.change(motion_, c, dr);
    return changed;
  }

  // Apart, and with copies: a vector whose address is given away lies in memory in all of update().
  [[gnu::noinline]] static ContactVector<N> relaxed(ContactVector<N> next, ContactVector<N> old,
                                                    double friction, double relaxation) {
    return project_on_friction_cone<N>(old + relaxation * (next - old), friction);
  }

  const Problem& problem_;
  typename Delassus::Motion motion_;
  Array<Record> record_;  // by place
};

/// Rigid spheres with friction: all that an update reads of a contact lies together in one record, a ball's
/// motion in one cache line, and vectors are held in four lanes. The local solution is closed (W_cc is
/// diagonal with equal tangential entries), so an update is one short chain of dependent operations.
template <ContactLaw Law>
requires(!Law::Contact::is_compliant &&
         Law::n_unknowns(3) == 3) class ContactKernel<ContactProblem<RigidBallsDelassus<3, 3>, Law>> {
  using Problem = ContactProblem<RigidBallsDelassus<3, 3>, Law>;

 public:
  ContactKernel(const Problem& problem, const Eigen::VectorXd& r) : problem_(problem) {
    const auto& delassus = problem.delassus;
    const Index n = problem.n_contacts(), n_bodies = delassus.bodies().size();
    body_.resize(n_bodies + 1);
    wall_ = static_cast<std::int32_t>(n_bodies);
    for (Index b = 0; b < n_bodies; ++b) {
      body_[b].velocity[3] = delassus.bodies()[b].mass;
      body_[b].spin[3] = delassus.bodies()[b].spin;
    }
    record_.resize(n);
    for (Index c = 0; c < n; ++c) {
      const BallContact<3>& contact = delassus.contacts()[c];
      const IsotropicBlock block = delassus.diagonal_block(c);
      Record& record = record_[c];
      record.contact = c;
      for (int i = 0; i < 3; ++i) {
        record.n[i] = contact.frame(0, i);
        record.t1[i] = contact.frame(1, i);
        record.t2[i] = contact.frame(2, i);
        record.free_velocity[static_cast<std::size_t>(i)] = problem.free_velocity[3 * c + i];
      }
      record.n[3] = block.normal > 0 ? 1 / block.normal : 0;
      record.t1[3] = block.tangential > 0 ? 1 / block.tangential : 0;
      record.t2[3] = problem.law[c].friction;
      record.candidate_arm = contact.candidate_arm;
      record.antagonist_arm = contact.antagonist >= 0 ? contact.antagonist_arm : 0;
      record.wall_rate = contact.antagonist >= 0 || delassus.mode_inverse_mass() == 0 ? 0 : contact.wall_rate;
      record.candidate = static_cast<std::int32_t>(contact.candidate);
      record.antagonist = contact.antagonist >= 0 ? static_cast<std::int32_t>(contact.antagonist) : wall_;
    }
    restart(r);
  }

  void restart(const Eigen::VectorXd& r) {
    const auto motion = problem_.delassus.motion(r);
    for (Index b = 0; b < motion.body.size(); ++b)
      for (int i = 0; i < 3; ++i) {
        body_[b].velocity[i] = motion.body[b].velocity[i];
        body_[b].spin[i] = motion.body[b].spin[i];
      }
    mode_ = motion.mode;
  }

  void arrange(const Array<Index>& order) {
    Array<Record> arranged(record_.size());
    for (const Record& record : record_) arranged[record.contact] = record;
    for (Index k = 0; k < order.size(); ++k) record_[k] = arranged[order[k]];
  }

  double visit(const Index* first, const Index* last, Eigen::VectorXd& r, double relaxation) {
    return relaxation == 1 ? visit<false>(first, last, r.data(), 1)
                           : visit<true>(first, last, r.data(), relaxation);
  }

 private:
  template <bool relaxed>
  double visit(const Index* first, const Index* last, double* r, double relaxation) {
    double changed = 0;
    for (; first != last; ++first) changed += update<relaxed>(*first, r, relaxation);
    return changed;
  }

  template <bool relaxed>
  [[gnu::always_inline]] inline double update(Index place, double* reactions, double relaxation) {
    const Record& record = record_[place];
    BodyMotion& a = body_[record.candidate];
    BodyMotion& b = body_[record.antagonist];
    const FourLanes velocity_a = a.velocity, velocity_b = b.velocity, spin_a = a.spin, spin_b = b.spin;
    // Whatever does not wait for the bodies: columns of the frame, and (0, -t2, t1) for the spins.
    const FourLanes even = __builtin_shufflevector(record.n, record.t1, 0, 4, 2, 6);  // n0 t0 n2 t2
    const FourLanes odd = __builtin_shufflevector(record.n, record.t1, 1, 5, 3, 7);   // n1 t1
    const FourLanes column0 = __builtin_shufflevector(even, record.t2, 0, 1, 4, 7);
    const FourLanes column1 = __builtin_shufflevector(odd, record.t2, 0, 1, 5, 7);
    const FourLanes column2 = __builtin_shufflevector(even, record.t2, 2, 3, 6, 7);
    FourLanes turn0, turn1, turn2;  // by reference: vectors as values have no one ABI
    quarter_turn(column0, turn0);
    quarter_turn(column1, turn1);
    quarter_turn(column2, turn2);
    const FourLanes inverse = __builtin_shufflevector(record.n, record.t1, 3, 7, 7, 3);
    const FourLanes only_vector = {1, 1, 1, 0};
    const FourLanes mass_a = only_vector * lane<3>(velocity_a), mass_b = only_vector * lane<3>(velocity_b);
    const FourLanes inertia_a = only_vector * (record.candidate_arm * lane<3>(spin_a)),
                    inertia_b = only_vector * (record.antagonist_arm * lane<3>(spin_b));
    double* const own = reactions + 3 * record.contact;
    const FourLanes old = {own[0], own[1], own[2], 0};

    const FourLanes approach = velocity_a - velocity_b;
    const FourLanes turning = record.candidate_arm * spin_a + record.antagonist_arm * spin_b;
    FourLanes u = ((record.free_velocity + lane<0>(approach) * column0) + lane<0>(turning) * turn0) +
                  (lane<1>(approach) * column1 + lane<1>(turning) * turn1) +
                  (lane<2>(approach) * column2 + lane<2>(turning) * turn2);
    if (record.wall_rate != 0) u[0] -= record.wall_rate * mode_;
    FourLanes dr = -inverse * u;
    dr[0] = dr[0] > -old[0] ? dr[0] : -old[0];
    FourLanes next = old + dr;
    const double limit = record.t2[3] * next[0], size2 = next[1] * next[1] + next[2] * next[2];
    if (size2 > limit * limit) {
      const double factor = limit / std::sqrt(size2);
      next *= FourLanes{1, factor, factor, 0};
      dr = next - old;
    }
    if constexpr (relaxed) {
      next = old + relaxation * dr;
      const double bound = record.t2[3] * next[0];
      if (!(next[0] >= 0 && next[1] * next[1] + next[2] * next[2] <= bound * bound)) {
        const ContactVector<3> projected =
            project_on_friction_cone<3>(ContactVector<3>(next[0], next[1], next[2]), record.t2[3]);
        next = FourLanes{projected[0], projected[1], projected[2], 0};
      }
      dr = next - old;
    }
    for (int i = 0; i < 3; ++i) own[i] = next[i];
    const FourLanes force = lane<0>(dr) * record.n + (lane<1>(dr) * record.t1 + lane<2>(dr) * record.t2);
    const FourLanes moment = lane<2>(dr) * record.t1 - lane<1>(dr) * record.t2;
    a.velocity = velocity_a + mass_a * force;
    a.spin = spin_a + inertia_a * moment;
    if (record.antagonist != wall_) {  // threads may share it
      b.velocity = velocity_b - mass_b * force;
      b.spin = spin_b + inertia_b * moment;
    }
    if (record.wall_rate != 0) mode_ -= problem_.delassus.mode_inverse_mass() * record.wall_rate * dr[0];
    return dr[0] * dr[0] + (dr[1] * dr[1] + dr[2] * dr[2]);
  }

  struct Record {
    FourLanes n;   // and 1 / W_NN
    FourLanes t1;  // and 1 / W_TT
    FourLanes t2;  // and friction
    FourLanes free_velocity = {};
    double candidate_arm, antagonist_arm, wall_rate;
    std::int32_t candidate, antagonist;
    Index contact;
  };
  struct alignas(64) BodyMotion {
    FourLanes velocity = {};  // and inverse mass
    FourLanes spin = {};      // and inverse moment of inertia
  };

  template <int I>
  static double lane(const FourLanes& x) {
    return x[I];
  }
  // (n, t1, t2) -> (0, -t2, t1)
  static void quarter_turn(const FourLanes& x, FourLanes& turned) {
    turned = FourLanes{0, -1, 1, 0} * __builtin_shufflevector(x, x, 0, 2, 1, 3);
  }

  const Problem& problem_;
  Array<Record> record_;
  Array<BodyMotion> body_;
  std::int32_t wall_ = 0;  // the last body, which stands for all walls and never moves
  double mode_ = 0;
};

}  // namespace jampack
