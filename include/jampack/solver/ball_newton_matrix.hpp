// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/LU>
#include <jampack/problem/rigid_balls_delassus.hpp>
#include <jampack/solver/newton_matrix.hpp>

namespace jampack {

/// The same between rigid balls, W = H M^-1 H^T, without W: with the velocities v = M^-1 H^T x of the bodies
/// as unknowns and the reactions eliminated,
///   (M + H^T C^-1 A H) v = H^T C^-1 b,   x = C^-1 (b - A H v)
/// (docs/theory/contact_solvers.md, eq. 19). A packing has several times fewer velocities than reactions,
/// and only bodies that touch are coupled; the mode in which walls move together borders the matrix. C, of
/// which alpha/rho times A is a part, must be regular.
template <int Dim, int N>
class NewtonMatrix<RigidBallsDelassus<Dim, N>> {
 public:
  using Stored = RigidBallsDelassus<Dim, N>;
  using Block = Eigen::Matrix<double, N, N>;
  static const Stored& stored(const Stored& w) { return w; }

  /// Sweeps that take as long as one factorisation, at 15 Gflop/s where an update takes 15 ns.
  static Index factorisation_in_sweeps(const Stored& w) {
    const double updates = static_cast<double>(std::max<Index>(w.n_contacts(), 1));
    return static_cast<Index>(NewtonMatrix(w).lu_.work() / (225 * updates));
  }

  /// `w` must outlive the matrix.
  explicit NewtonMatrix(const Stored& w, Threads = {}) : w_(w), contacts_of_body_(w.bodies().size()) {
    Array<Array<Index>> neighbours(w.bodies().size());
    for (Index c = 0; c < w.n_contacts(); ++c) {
      const auto& [a, b] = bodies(c);
      contacts_of_body_[a].push_back(c);
      if (b < 0) continue;
      contacts_of_body_[b].push_back(c);
      neighbours[a].push_back(b);
      neighbours[b].push_back(a);
    }
    for (auto& list : neighbours) {
      std::sort(list.begin(), list.end());
      list.erase(std::unique(list.begin(), list.end()), list.end());
    }
    lu_.analyse(neighbours);
  }

  /// As the general one. One step of iterative refinement: where alpha is small, b - A H v cancels.
  bool solve(const Array<int>& n_rows, const Array<Block>& a, const Array<Block>& constant,
             Eigen::VectorXd& x) {
    if (!factorise(n_rows, a, constant)) return false;
    const Eigen::VectorXd right_hand_side = x;
    substitute(n_rows, a, x);
    Eigen::VectorXd part(x.size()), u, rest = right_hand_side;
    for (Index c = 0; c < n_rows.size(); ++c) part.template segment<N>(N * c) = kept(x, c, n_rows[c]);
    w_.apply(part, u);
    for (Index c = 0; c < n_rows.size(); ++c)
      rest.template segment<N>(N * c) -=
          a[c] * u.template segment<N>(N * c) + constant[c] * part.template segment<N>(N * c);
    substitute(n_rows, a, rest);
    for (Index c = 0; c < n_rows.size(); ++c) x.template segment<N>(N * c) += kept(rest, c, n_rows[c]);
    return x.allFinite();
  }

 private:
  static constexpr int n_spins = N == 1 ? 0 : Spin<Dim>::RowsAtCompileTime;
  static constexpr int n_motions = Dim + n_spins;  // of a body
  using Jacobian = Eigen::Matrix<double, N, n_motions>;
  using BodyVector = Eigen::Matrix<double, n_motions, 1>;
  using BodyBlock = Eigen::Matrix<double, n_motions, n_motions>;

  std::pair<Index, Index> bodies(Index c) const {
    return {w_.contacts()[c].candidate, w_.contacts()[c].antagonist};
  }

  /// Velocity at contact c by the motion of one of its bodies; none by motions without inverse inertia.
  Jacobian jacobian(Index c, Index body) const {
    const BallContact<Dim>& contact = w_.contacts()[c];
    const bool candidate = contact.candidate == body;
    const InverseInertia& inertia = w_.bodies()[body];
    Jacobian h = Jacobian::Zero();
    if (inertia.mass > 0)
      h.template leftCols<Dim>() = (candidate ? 1.0 : -1.0) * contact.frame.template topRows<N>();
    if constexpr (N > 1)
      if (inertia.spin > 0) {
        const double arm = candidate ? contact.candidate_arm : contact.antagonist_arm;
        if constexpr (N == 2) h(1, Dim) = -arm;
        if constexpr (N == 3) {
          h.template block<1, 3>(1, Dim) = -arm * contact.frame.row(2);
          h.template block<1, 3>(2, Dim) = arm * contact.frame.row(1);
        }
      }
    return h;
  }

  /// The same by the mode in which walls move together.
  double mode_rate(Index c) const {
    const BallContact<Dim>& contact = w_.contacts()[c];
    return contact.antagonist < 0 && w_.mode_inverse_mass() > 0 ? -contact.wall_rate : 0.0;
  }

  /// The unknowns of contact c that take part, others zero.
  static ContactVector<N> kept(const Eigen::VectorXd& x, Index c, int n_rows) {
    ContactVector<N> part;
    for (int i = 0; i < N; ++i) part[i] = i < n_rows ? x[N * c + i] : 0.0;
    return part;
  }

  bool factorise(const Array<int>& n_rows, const Array<Block>& a, const Array<Block>& constant) {
    const Index n = w_.n_contacts(), n_bodies = w_.bodies().size();
    inverse_.assign(n, Block::Zero());
    mode_column_.setZero(n_motions * n_bodies);
    mode_row_.setZero(n_motions * n_bodies);
    mode_corner_ = w_.mode_inverse_mass() > 0 ? 1 / w_.mode_inverse_mass() : 1;
    Array<Block> stiffness(n, Block::Zero());  // C^-1 A
    for (Index c = 0; c < n; ++c) {
      if (n_rows[c] == 0) continue;
      if (n_rows[c] == N)
        inverse_[c] = constant[c].inverse();
      else
        inverse_[c](0, 0) = 1 / constant[c](0, 0);
      if (!inverse_[c].allFinite()) return false;
      stiffness[c] = inverse_[c] * a[c];
      const double rate = mode_rate(c);
      if (rate == 0) continue;
      const Index body = bodies(c).first;
      const Jacobian h = jacobian(c, body);
      mode_column_.template segment<n_motions>(n_motions * body) +=
          h.transpose() * stiffness[c].col(0) * rate;
      mode_row_.template segment<n_motions>(n_motions * body) +=
          (rate * (stiffness[c].row(0) * h)).transpose();
      mode_corner_ += rate * stiffness[c](0, 0) * rate;
    }
    const bool factorised = lu_.factorise([&](Index body, auto add) {
      const InverseInertia& inertia = w_.bodies()[body];
      BodyBlock own = BodyBlock::Identity();
      if (inertia.mass > 0) own.diagonal().template head<Dim>().setConstant(1 / inertia.mass);
      if (inertia.spin > 0) own.diagonal().template tail<n_spins>().setConstant(1 / inertia.spin);
      for (const Index c : contacts_of_body_[body]) {
        if (n_rows[c] == 0) continue;
        const auto& [first, second] = bodies(c);
        const Jacobian h = jacobian(c, body);
        const Eigen::Matrix<double, n_motions, N> force = h.transpose() * stiffness[c];
        own += force * h;
        if (second < 0) continue;
        const Index other = first == body ? second : first;
        add(other, force * jacobian(c, other));
      }
      add(body, own);
    });
    if (!factorised) return false;
    mode_answer_ = mode_column_;
    lu_.solve(mode_answer_);
    mode_pivot_ = mode_corner_ - mode_row_.dot(mode_answer_);
    return mode_pivot_ != 0 && mode_answer_.allFinite();
  }

  void substitute(const Array<int>& n_rows, const Array<Block>& a, Eigen::VectorXd& x) const {
    Eigen::VectorXd v = Eigen::VectorXd::Zero(n_motions * w_.bodies().size());
    double mode = 0;
    const auto motion = [&](Index body) { return v.template segment<n_motions>(n_motions * body); };
    for (Index c = 0; c < w_.n_contacts(); ++c) {
      if (n_rows[c] == 0) continue;
      const ContactVector<N> force = inverse_[c] * x.template segment<N>(N * c);
      const auto& [first, second] = bodies(c);
      motion(first) += jacobian(c, first).transpose() * force;
      if (second >= 0) motion(second) += jacobian(c, second).transpose() * force;
      mode += mode_rate(c) * force[0];
    }
    lu_.solve(v);
    mode = (mode - mode_row_.dot(v)) / mode_pivot_;
    v -= mode * mode_answer_;
    for (Index c = 0; c < w_.n_contacts(); ++c) {
      if (n_rows[c] == 0) continue;
      const auto& [first, second] = bodies(c);
      ContactVector<N> u = jacobian(c, first) * motion(first);
      if (second >= 0) u += jacobian(c, second) * motion(second);
      u[0] += mode_rate(c) * mode;
      // The rows of the inverse that do not take part are zero.
      const ContactVector<N> answer =
          inverse_[c] * (ContactVector<N>(x.template segment<N>(N * c)) - a[c] * u);
      for (int i = 0; i < N; ++i)
        if (i < n_rows[c]) x[N * c + i] = answer[i];
    }
  }

  const Stored& w_;
  Array<Array<Index>> contacts_of_body_;
  BlockSparseLU<n_motions> lu_;
  Array<Block> inverse_;  // of C where a contact takes part
  Eigen::VectorXd mode_column_, mode_row_, mode_answer_;
  double mode_corner_ = 1, mode_pivot_ = 1;
};

}  // namespace jampack
