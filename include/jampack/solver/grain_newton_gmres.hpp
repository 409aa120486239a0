// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <jampack/core/parallel.hpp>
#include <jampack/core/splitmix.hpp>
#include <jampack/problem/grain_compliance_delassus.hpp>
#include <jampack/solver/contact_groups.hpp>
#include <jampack/solver/gmres.hpp>

namespace jampack {

/// GMRES on the Newton matrix A W + C between deformable grains, preconditioned on two levels. Far apart on a
/// grain, contacts feel each other through few *modes* of it (rigid motions, uniform strains), near by
/// through the contacts of the same pair of bodies, their *group*:
///   W ~ sum over grains F F^T + (W - sum F F^T within the groups),
/// with F F^T the Nyström approximation of a grain's C from a few random vectors. The second part is
/// factorised group by group, the first comes in by the Woodbury formula
/// (docs/theory/contact_solvers.md, section 5).
template <int N>
class GrainNewtonGmres {
 public:
  using Delassus = GrainComplianceDelassus<N>;
  using Block = Eigen::Matrix<double, N, N>;

  /// `w` must outlive the solver; `groups` are its contacts by bodies.
  GrainNewtonGmres(const Delassus& w, const Array<ContactGroup>& groups, Threads threads)
      : w_(w), threads_(threads), groups_(groups.size()), start_(w.n_contacts()), first_mode_{0} {
    for (Index g = 0; g < w.n_grains(); ++g)
      first_mode_.push_back(first_mode_.back() + std::min(modes_of_a_grain, w.compliance(g).cols()));
    for (Index k = 0; k < groups.size(); ++k) {
      groups_[k].contacts = groups[k].contacts;
      w.for_each_place(groups[k].contacts.front(), [&](Index grain, Index) {
        groups_[k].grains.push_back(grain);
        groups_[k].n_modes += n_modes(grain);
      });
    }
  }

  /// Floating-point operations of a solution, as far as they can be known before it.
  double work(const Array<int>& n_rows) const {
    // A product with W waits for memory: an operation takes the time of four.
    constexpr double iterations = 10, slow = 4;
    double sum = 2.0 / 3 * std::pow(static_cast<double>(first_mode_.back()), 3) +
                 iterations * slow * 2 * static_cast<double>(w_.n_stored());
    for (const Group& group : groups_) {
      double n = 0;
      for (const Index c : group.contacts) n += n_rows[c];
      const double m = static_cast<double>(group.n_modes);
      sum += 2 * n * (n * n / 3 + n * m + m * m);
    }
    return sum;
  }

  /// x, the right-hand side, becomes the solution, up to `tolerance` relative to it; unknowns that do not
  /// take part stay as they are. False, with x as it was, if that was not reached.
  bool solve(const Array<int>& n_rows, const Array<Block>& a, const Array<Block>& constant, double tolerance,
             Eigen::VectorXd& x) {
    constexpr Index max_iterations = 60;
    if (!prepare(n_rows, a, constant)) return false;
    Eigen::VectorXd y(size_), r(N * n_rows.size()), u;
    for_each_unknown(n_rows, [&](Index i, Index j) { y[i] = x[j]; });
    const auto product = [&](const Eigen::VectorXd& v, Eigen::VectorXd& out) {
      r.setZero();
      for_each_unknown(n_rows, [&](Index i, Index j) { r[j] = v[i]; });
      w_.apply(r, u);
      out.resize(size_);
      for (Index c = 0; c < n_rows.size(); ++c)
        if (n_rows[c] > 0)
          out.segment(start_[c], n_rows[c]) =
              (a[c] * u.template segment<N>(N * c) + constant[c] * r.template segment<N>(N * c))
                  .head(n_rows[c]);
    };
    const double left = gmres(
        product, [&](Eigen::VectorXd& v) { precondition_packed(v); }, y, tolerance, max_iterations);
    if (!(left <= tolerance)) return false;
    for_each_unknown(n_rows, [&](Index i, Index j) { x[j] = y[i]; });
    return true;
  }

  /// Sets up the preconditioner; false if there is none.
  bool prepare(const Array<int>& n_rows, const Array<Block>& a, const Array<Block>& constant) {
    if (modes_.empty()) find_modes();
    n_rows_ = n_rows;
    return factorise(n_rows, a, constant);
  }

  /// x becomes about (A W + C)^-1 x; unknowns that do not take part stay as they are.
  void precondition(Eigen::VectorXd& x) const {
    Eigen::VectorXd y(size_);
    for_each_unknown(n_rows_, [&](Index i, Index j) { y[i] = x[j]; });
    precondition_packed(y);
    for_each_unknown(n_rows_, [&](Index i, Index j) { x[j] = y[i]; });
  }

 private:
  static constexpr Index modes_of_a_grain = 16;

  struct Group {
    Array<Index> contacts, grains;
    Index n_modes = 0;           ///< of its grains together
    Eigen::MatrixXd compliance;  ///< W - F F^T within the group
    Eigen::MatrixXd modes;       ///< its rows of F
    Index first = 0, size = 0;   ///< of its unknowns that take part, below in this order:
    Eigen::MatrixXd own_modes;   ///< F
    Eigen::MatrixXd answer;      ///< pivot^-1 A F
    Eigen::PartialPivLU<Eigen::MatrixXd> pivot;
  };

  Index n_modes(Index grain) const { return first_mode_[grain + 1] - first_mode_[grain]; }

  void find_modes() {
    modes_.resize(w_.n_grains());
    parallel_for(threads_, w_.n_grains(), [&](Index grain) {
      if (n_modes(grain) == 0) return;
      std::uint64_t state = 1;
      const Eigen::MatrixXd probe = Eigen::MatrixXd::NullaryExpr(
          w_.compliance(grain).cols(), n_modes(grain),
          [&] { return static_cast<double>(splitmix(state) >> 11) * 0x1p-53 - 0.5; });
      const Eigen::MatrixXd answer = w_.compliance(grain) * probe;
      Eigen::MatrixXd gram = probe.transpose() * answer;
      gram.diagonal().array() += 1e-12 * gram.trace();
      modes_[grain] = gram.llt().matrixL().solve(answer.transpose()).transpose();
    });
    parallel_for(threads_, groups_.size(), [&](Index k) {
      Group& group = groups_[k];
      group.modes.setZero(N * group.contacts.size(), group.n_modes);
      for (Index i = 0; i < group.contacts.size(); ++i) {
        Index column = 0;
        const int rows = w_.n_rows(group.contacts[i]);
        w_.for_each_place(group.contacts[i], [&](Index grain, Index row) {
          group.modes.block(N * i, column, rows, n_modes(grain)) = modes_[grain].middleRows(row, rows);
          column += n_modes(grain);
        });
      }
      group.compliance.noalias() = -group.modes * group.modes.transpose();
      for (Index i = 0; i < group.contacts.size(); ++i)
        for (Index j = 0; j < group.contacts.size(); ++j)
          group.compliance.template block<N, N>(N * i, N * j) +=
              w_.block(group.contacts[i], group.contacts[j]);
    });
  }

  bool factorise(const Array<int>& n_rows, const Array<Block>& a, const Array<Block>& constant) {
    size_ = 0;
    for (Group& group : groups_) {
      group.first = size_;
      for (const Index c : group.contacts) {
        start_[c] = size_;
        size_ += n_rows[c];
      }
      group.size = size_ - group.first;
    }
    Array<Eigen::MatrixXd> coupling(groups_.size());
    parallel_for(threads_, groups_.size(), [&](Index k) {
      Group& group = groups_[k];
      Eigen::MatrixXd matrix(group.size, group.size), rows(group.size, group.n_modes);
      group.own_modes.resize(group.size, group.n_modes);
      for (Index p = 0; p < group.contacts.size(); ++p) {
        const Index c = group.contacts[p], n = n_rows[c], i = start_[c] - group.first;
        if (n == 0) continue;
        group.own_modes.middleRows(i, n) = group.modes.middleRows(N * p, n);
        // Row by row: for N = 1 Eigen 3.4 takes wrong entries in a[c].topRows(n) * rows.
        for (Index row = 0; row < n; ++row) {
          rows.row(i + row) = a[c](row, 0) * group.modes.row(N * p);
          for (int j = 1; j < N; ++j) rows.row(i + row) += a[c](row, j) * group.modes.row(N * p + j);
        }
        for (Index q = 0; q < group.contacts.size(); ++q) {
          const Index d = group.contacts[q];
          const Block part = a[c] * group.compliance.template block<N, N>(N * p, N * q);
          matrix.block(i, start_[d] - group.first, n, n_rows[d]) = part.topLeftCorner(n, n_rows[d]);
        }
        matrix.block(i, i, n, n) += constant[c].topLeftCorner(n, n);
      }
      if (group.size == 0) return;
      group.pivot.compute(matrix);
      group.answer = group.pivot.solve(rows);
      coupling[k].noalias() = group.own_modes.transpose() * group.answer;
    });
    const Index n = first_mode_.back();
    Eigen::MatrixXd schur = Eigen::MatrixXd::Identity(n, n);
    for (Index k = 0; k < groups_.size(); ++k)
      if (groups_[k].size > 0)
        for_each_grain(groups_[k], [&](Index g, Index i) {
          for_each_grain(groups_[k], [&](Index h, Index j) {
            schur.block(first_mode_[g], first_mode_[h], n_modes(g), n_modes(h)) +=
                coupling[k].block(i, j, n_modes(g), n_modes(h));
          });
        });
    coarse_.compute(schur);
    return schur.allFinite();
  }

  /// v becomes about (A W + C)^-1 v.
  void precondition_packed(Eigen::VectorXd& v) const {
    Eigen::VectorXd coarse = Eigen::VectorXd::Zero(first_mode_.back()), part;
    for (const Group& group : groups_) {
      if (group.size == 0) continue;
      auto own = v.segment(group.first, group.size);
      own = group.pivot.solve(own).eval();
      part.noalias() = group.own_modes.transpose() * own;
      for_each_grain(group, [&](Index g, Index i) {
        coarse.segment(first_mode_[g], n_modes(g)) += part.segment(i, n_modes(g));
      });
    }
    coarse = coarse_.solve(coarse).eval();
    for (const Group& group : groups_) {
      if (group.size == 0) continue;
      part.resize(group.n_modes);
      for_each_grain(group, [&](Index g, Index i) {
        part.segment(i, n_modes(g)) = coarse.segment(first_mode_[g], n_modes(g));
      });
      v.segment(group.first, group.size).noalias() -= group.answer * part;
    }
  }

  /// Visits the grains of a group, with the first of their modes among its own.
  template <class Visit>
  void for_each_grain(const Group& group, Visit visit) const {
    Index i = 0;
    for (const Index g : group.grains) {
      visit(g, i);
      i += n_modes(g);
    }
  }
  /// Visits the unknowns that take part: where they are here, and among all.
  template <class Visit>
  void for_each_unknown(const Array<int>& n_rows, Visit visit) const {
    for (Index c = 0; c < n_rows.size(); ++c)
      for (int row = 0; row < n_rows[c]; ++row) visit(start_[c] + row, N * c + row);
  }

  const Delassus& w_;
  Threads threads_;
  Array<Group> groups_;
  Array<int> n_rows_;        ///< of the last preparation
  Array<Index> start_;       ///< of a contact's unknowns
  Array<Index> first_mode_;  ///< of a grain, among all
  Array<Eigen::MatrixXd> modes_;
  Index size_ = 0;
  Eigen::PartialPivLU<Eigen::MatrixXd> coarse_;
};

}  // namespace jampack
