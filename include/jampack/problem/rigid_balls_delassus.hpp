// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/core/error.hpp>
#include <jampack/geometry/frame.hpp>
#include <jampack/problem/block_sparse_delassus.hpp>
#include <string>
#include <utility>

namespace jampack {

/// Inertia of a ball as the Delassus operator needs it; zeros for a body that does not move.
struct InverseInertia {
  double mass;  ///< 1 / mass
  double spin;  ///< 1 / moment of inertia about the centre (0 where rotation is not wanted)
};

/// A contact of a ball with a ball or a wall (signs and frame: geometry/frame.hpp).
template <int Dim>
struct BallContact {
  Index candidate;       ///< ball
  Index antagonist;      ///< ball, or -1: a wall
  Frame<Dim> frame;      ///< rows n, t1, t2; n from antagonist to candidate
  double candidate_arm;  ///< distance from the candidate's centre to the contact point (at centre - arm n)
  double antagonist_arm = 0;  ///< the same for the antagonist (at centre + arm n)
  double wall_rate =
      0;  ///< a wall's velocity along n per unit of the box mode; 0: the wall's velocity is in q
};

/// Delassus operator of rigid balls, W = H M^-1 H^T, never formed: reactions act on the bodies' velocities
/// and a contact reads two of them. W_cc is known in closed form and diagonal, since the lever arms of a ball
/// lie along n (docs/theory/contact_solvers.md, eq. 8 and 9). N = Dim with friction, or 1 without.
///
/// The walls of a box may move together in one mode of speed s (stress-driven box): a wall contact then sees
/// u_N = n . v - wall_rate s, and s has the inverse mass `mode_inverse_mass`.
template <int Dim, int N>
class RigidBallsDelassus {
  static_assert(N == 1 || N == Dim, "a contact has 1 unknown (frictionless) or Dim");

 public:
  static constexpr int n_unknowns = N;
  static constexpr int n_spins = Spin<Dim>::RowsAtCompileTime;

  /// A ball's change of velocity and spin by the reactions, with its inverse inertia beside it: a cache line
  /// of its own, so that threads that move neighbouring balls do not take each other's lines. Frictionless
  /// contacts turn nothing and carry no spin.
  struct alignas(64) BodyMotion {
    Vector<Dim> velocity = Vector<Dim>::Zero();
    using SpinIfAny = Eigen::Matrix<double, N == 1 ? 0 : n_spins, 1>;
    SpinIfAny spin = SpinIfAny::Zero();
    double inverse_mass = 0, inverse_spin = 0;
    void stop() {
      velocity.setZero();
      spin.setZero();
    }
  };
  struct Motion {
    Array<BodyMotion> body;
    double mode = 0;  ///< speed of the box mode
  };

  RigidBallsDelassus(Array<InverseInertia> bodies, Array<BallContact<Dim>> contacts,
                     double mode_inverse_mass = 0)
      : bodies_(std::move(bodies)), contacts_(std::move(contacts)), mode_inverse_mass_(mode_inverse_mass) {
    const Index n = bodies_.size();
    for (const auto& body : bodies_)
      require(body.mass >= 0 && body.spin >= 0, "rigid balls: inverse mass and inverse inertia must be >= 0");
    for (Index c = 0; c < contacts_.size(); ++c)
      require(
          contacts_[c].candidate >= 0 && contacts_[c].candidate < n && contacts_[c].antagonist >= -1 &&
              contacts_[c].antagonist < n && contacts_[c].frame.allFinite(),
          "rigid balls: contact " + std::to_string(c) + " names a ball that is not there or has no frame");
  }

  Index n_contacts() const { return contacts_.size(); }
  const Array<InverseInertia>& bodies() const { return bodies_; }
  const Array<BallContact<Dim>>& contacts() const { return contacts_; }
  double mode_inverse_mass() const { return mode_inverse_mass_; }

  IsotropicBlock diagonal_block(Index c) const {
    const BallContact<Dim>& contact = contacts_[c];
    const InverseInertia& a = bodies_[contact.candidate];
    IsotropicBlock block{a.mass, a.mass + a.spin * contact.candidate_arm * contact.candidate_arm};
    if (contact.antagonist >= 0) {
      const InverseInertia& b = bodies_[contact.antagonist];
      block.normal += b.mass;
      block.tangential += b.mass + b.spin * contact.antagonist_arm * contact.antagonist_arm;
    } else {
      block.normal += contact.wall_rate * contact.wall_rate * mode_inverse_mass_;
    }
    return block;
  }

  Motion motion(const Eigen::VectorXd& r) const {
    Motion motion;
    motion.body.resize(bodies_.size());
    for (Index b = 0; b < bodies_.size(); ++b) {
      motion.body[b].inverse_mass = bodies_[b].mass;
      motion.body[b].inverse_spin = bodies_[b].spin;
    }
    for (Index c = 0; c < n_contacts(); ++c) change(motion, c, r.template segment<N>(N * c));
    return motion;
  }

  [[gnu::always_inline]] ContactVector<N> velocity(const Motion& motion, const Eigen::VectorXd&,
                                                   Index c) const {
    const BallContact<Dim>& contact = contacts_[c];
    const BodyMotion& a = motion.body[contact.candidate];
    ContactVector<N> u;
    Spin<Dim> arm_times_spin;
    if constexpr (N > 1) {
#pragma GCC unroll 9
      for (int i = 0; i < n_spins; ++i) arm_times_spin[i] = contact.candidate_arm * a.spin[i];
    }
    if (contact.antagonist >= 0) {
      const BodyMotion& b = motion.body[contact.antagonist];
      Vector<Dim> relative;
#pragma GCC unroll 9
      for (int i = 0; i < Dim; ++i) relative[i] = a.velocity[i] - b.velocity[i];
      in_frame(contact, relative, u);
      if constexpr (N > 1) {
#pragma GCC unroll 9
        for (int i = 0; i < n_spins; ++i) arm_times_spin[i] += contact.antagonist_arm * b.spin[i];
      }
    } else {
      in_frame(contact, a.velocity, u);
      u[0] -= contact.wall_rate * motion.mode;
    }
    if constexpr (N == 2) u[1] -= arm_times_spin[0];
    if constexpr (N == 3)
#pragma GCC unroll 9
      for (int i = 0; i < 3; ++i) {
        u[1] -= contact.frame(2, i) * arm_times_spin[i];
        u[2] += contact.frame(1, i) * arm_times_spin[i];
      }
    return u;
  }

  [[gnu::always_inline]] void change(Motion& motion, Index c, const ContactVector<N>& dr) const {
    const BallContact<Dim>& contact = contacts_[c];
    Vector<Dim> force;
#pragma GCC unroll 9
    for (int i = 0; i < Dim; ++i) force[i] = contact.frame(0, i) * dr[0];
#pragma GCC unroll 9
    for (int k = 0; k < Dim * (N - 1); ++k)
      force[k % Dim] += contact.frame(k / Dim + 1, k % Dim) * dr[k / Dim + 1];
    BodyMotion& a = motion.body[contact.candidate];
#pragma GCC unroll 9
    for (int i = 0; i < Dim; ++i) a.velocity[i] += a.inverse_mass * force[i];
    Spin<Dim> moment;  // per arm, the same for both bodies: -n x r
    if constexpr (N == 2) moment[0] = -dr[1];
    if constexpr (N == 3) {
#pragma GCC unroll 9
      for (int i = 0; i < 3; ++i) moment[i] = dr[2] * contact.frame(1, i) - dr[1] * contact.frame(2, i);
    }
    const auto turn = [&](BodyMotion & body, double arm) __attribute__((always_inline)) {
      const double factor = body.inverse_spin * arm;
      if constexpr (N > 1) {
#pragma GCC unroll 9
        for (int i = 0; i < n_spins; ++i) body.spin[i] += factor * moment[i];
      }
    };
    turn(a, contact.candidate_arm);
    if (contact.antagonist >= 0) {
      BodyMotion& b = motion.body[contact.antagonist];
#pragma GCC unroll 9
      for (int i = 0; i < Dim; ++i) b.velocity[i] -= b.inverse_mass * force[i];
      turn(b, contact.antagonist_arm);
    } else if (moves_mode(contact)) {
      motion.mode -= mode_inverse_mass_ * contact.wall_rate * dr[0];
    }
  }

  void apply(const Eigen::VectorXd& r, Eigen::VectorXd& u) const {
    const Motion moved = motion(r);
    u.resize(N * n_contacts());
    for (Index c = 0; c < n_contacts(); ++c) u.template segment<N>(N * c) = velocity(moved, r, c);
  }

  /// Visits the bodies of contact c, and the box mode (as a last body) where it moves.
  template <class Visit>
  void for_each_body(Index c, Visit visit) const {
    visit(contacts_[c].candidate);
    if (contacts_[c].antagonist >= 0)
      visit(contacts_[c].antagonist);
    else if (moves_mode(contacts_[c]))
      visit(bodies_.size());
  }

  /// All blocks of W that are not zero.
  Array<DelassusBlock<N>> blocks() const {
    Array<Array<Index>> on_body(bodies_.size() + 1);  // the last stands for the box mode
    for (Index c = 0; c < n_contacts(); ++c) {
      on_body[contacts_[c].candidate].push_back(c);
      if (contacts_[c].antagonist >= 0)
        on_body[contacts_[c].antagonist].push_back(c);
      else if (mode_inverse_mass_ > 0)
        on_body.back().push_back(c);
    }
    const Eigen::VectorXd none;
    Motion moved = motion(Eigen::VectorXd::Zero(N * n_contacts()));
    Array<DelassusBlock<N>> all;
    Array<Index> seen(n_contacts(), Index{-1});
    for (Index d = 0; d < n_contacts(); ++d) {
      const Index first = all.size(), a = contacts_[d].candidate, b = contacts_[d].antagonist;
      for (int j = 0; j < N; ++j) {
        change(moved, d, ContactVector<N>::Unit(j));
        for (const Index body : {a, b >= 0 ? b : bodies_.size()})
          for (const Index c : on_body[body]) {
            if (seen[c] < first) {
              seen[c] = all.size();
              all.push_back({c, d, Eigen::Matrix<double, N, N>::Zero()});
            }
            all[seen[c]].value.col(j) = velocity(moved, none, c);
          }
        moved.body[a].stop();
        if (b >= 0) moved.body[b].stop();
        moved.mode = 0;
      }
    }
    return all;
  }

 private:
  bool moves_mode(const BallContact<Dim>& wall_contact) const {
    return mode_inverse_mass_ > 0 && wall_contact.wall_rate != 0;
  }

  // Velocity of the contact points by spin: omega x (-arm n), in the local frame.
  [[gnu::always_inline]] static void in_frame(const BallContact<Dim>& contact, const Vector<Dim>& v,
                                              ContactVector<N>& u) {
#pragma GCC unroll 9
    for (int k = 0; k < N; ++k) u[k] = contact.frame(k, 0) * v[0];
#pragma GCC unroll 9
    for (int k = 0; k < N * (Dim - 1); ++k) u[k % N] += contact.frame(k % N, k / N + 1) * v[k / N + 1];
  }
  Array<InverseInertia> bodies_;
  Array<BallContact<Dim>> contacts_;
  double mode_inverse_mass_ = 0;
};

static_assert(DelassusOperator<RigidBallsDelassus<3, 3>> && DelassusOperator<RigidBallsDelassus<2, 1>>);

}  // namespace jampack
