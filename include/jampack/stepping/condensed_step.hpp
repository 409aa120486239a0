// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/body/block_cholesky.hpp>
#include <jampack/body/soft_packing.hpp>
#include <jampack/core/parallel.hpp>
#include <jampack/detection/surface_contact.hpp>
#include <jampack/geometry/frame.hpp>
#include <jampack/law/contact_law.hpp>
#include <jampack/problem/contact_problem.hpp>
#include <jampack/problem/grain_compliance_delassus.hpp>
#include <jampack/stepping/contact_spread.hpp>
#include <numeric>

namespace jampack {

/// One linearised step as a contact problem: the grains' tangents are condensed on the contacts,
///   s = W r + q,   W = H T^-1 H^T,   q = s(x) - H T^-1 R0,
/// with s the displacements of the contacts in the step and R0 the imbalance without contact forces
/// (docs/theory/deformable_stage.md, section 6). Any contact solver can solve it.
template <class Packing, ContactLaw Law>
class CondensedStep {
 public:
  static constexpr int Dim = Packing::dimension;
  static constexpr int N = n_contact_unknowns<Law, Dim>;
  using Nodal = typename Packing::Nodal;
  using Problem = ContactProblem<GrainComplianceDelassus<N>, Law>;

  /// One contact of the problem and its displacement in the step at x.
  struct Entry {
    const SurfaceContact<Dim>* contact;
    Vector<Dim> displacement;  ///< global axes
  };

  Threads threads;

  /// Factorises the positive definite tangents `tangent` grain by grain.
  void factorise(const Packing& packing, const Array<BlockMatrix<Dim>>& tangent) {
    if (factor_.size() != tangent.size()) {
      factor_.clear();
      for (Index g = 0; g < tangent.size(); ++g) factor_.emplace_back().analyse(packing.model->cholesky);
    }
    parallel_for(threads, tangent.size(), [&](Index g) {
      if (!factor_[g].factorise(tangent[g]))
        throw NotConverged("condensed step: the tangent of grain " + std::to_string(g) +
                           " is not positive definite");
    });
  }

  /// The contact problem of these contacts; `imbalance` is R0 of each grain. Its products with W use the
  /// factors: it is to be done with before they change, and not to outlive them.
  Problem problem(const Packing& packing, const Array<Entry>& entries, const Array<Nodal>& imbalance,
                  const Law& law) {
    const Index n_grains = packing.grains.size(), n = Dim * packing.n_nodes();
    Array<GrainCompliance<N>> grains(n_grains);
    pull_.resize(n_grains);
    sides_.assign(n_grains, {});
    spread_ = ContactSpread<Dim, N>(n_grains);
    for (Index c = 0; c < entries.size(); ++c) {
      const auto& contact = *entries[c].contact;
      auto axes = rows(contact);
      const int n_rows = contact.is_wall() ? 1 : N;  // walls have no friction
      for (int i = n_rows; i < N; ++i) axes.row(i).setZero();
      spread_.add(contact, c, axes);
      const auto belongs_to = [&](Index grain, double sign) {
        grains[grain].contact.push_back(c);
        grains[grain].sign.push_back(sign);
        grains[grain].n_rows.push_back(n_rows);
      };
      belongs_to(contact.candidate, 1);
      if (!contact.is_wall()) belongs_to(contact.antagonist, -1);
    }
    Eigen::VectorXd q = Eigen::VectorXd::Zero(N * entries.size());
    Array<Eigen::VectorXd> moved(n_grains);
    parallel_for(threads, n_grains, [&](Index g) {
      auto& grain = grains[g];
      sides_[g] = {grain.contact, grain.sign, grain.n_rows};
      const Index m = std::accumulate(grain.n_rows.begin(), grain.n_rows.end(), Index{0});
      // Columns: the pulls of the contacts, then the load.
      pull_[g].setZero(n, m + 1);
      pull_[g].col(m) = -Eigen::Map<const Eigen::VectorXd>(imbalance[g].data(), n);
      sides_[g].for_each([&](Index c, double sign, Index column, int n_rows) {
        const auto& contact = *entries[c].contact;
        const Eigen::Matrix<double, Dim, N> axes = rows(contact).transpose();
        contact.for_each_node([&](Index owner, Index node, double weight) {
          for (int i = 0; owner == g && i < n_rows; ++i)
            pull_[g].col(column + i).template segment<Dim>(Dim * node) += sign * weight * axes.col(i);
        });
      });
      factor_[g].forward(pull_[g]);
      const auto own = pull_[g].leftCols(m);
      grain.compliance.noalias() = own.transpose() * own;
      moved[g].noalias() = own.transpose() * pull_[g].col(m);
    });
    Array<typename Law::Contact> laws;
    for (Index c = 0; c < entries.size(); ++c) {
      const bool is_wall = entries[c].contact->is_wall();
      const ContactVector<N> u = rows(*entries[c].contact) * entries[c].displacement;
      for (int i = 0; i < (is_wall ? 1 : N); ++i) q[N * c + i] = u[i];
      laws.push_back(is_wall ? typename Law::Contact{} : law);
    }
    for (Index g = 0; g < n_grains; ++g)
      sides_[g].for_each([&](Index c, double sign, Index row, int n_rows) {
        for (int i = 0; i < n_rows; ++i) q[N * c + i] += sign * moved[g][row + i];
      });
    GrainComplianceDelassus<N> delassus(entries.size(), std::move(grains));
    Index in_factors = 0;
    for (const auto& factor : factor_) in_factors += 2 * factor.n_stored();
    if (delassus.n_stored() > in_factors)
      delassus.use_product([this](const Eigen::VectorXd& r, Eigen::VectorXd& u) { apply(r, u); });
    return Problem(std::move(delassus), std::move(q), std::move(laws));
  }

  /// The motion of all grains that goes with the reactions of the last problem().
  void motion(const Eigen::VectorXd& reaction, Eigen::VectorXd& dx) const {
    const Index n_grains = pull_.size(), n = pull_[0].rows();
    dx.resize(n * n_grains);
    parallel_for(threads, n_grains, [&](Index g) {
      Eigen::VectorXd own(pull_[g].cols());
      sides_[g].for_each([&](Index c, double sign, Index row, int n_rows) {
        for (int i = 0; i < n_rows; ++i) own[row + i] = sign * reaction[N * c + i];
      });
      own[own.size() - 1] = 1;
      Eigen::VectorXd moved = pull_[g] * own;
      factor_[g].backward(moved);
      dx.segment(n * g, n) = moved;
    });
  }

  /// T^-1 load on grain g.
  Eigen::VectorXd solve(Index g, const Eigen::VectorXd& load) const { return factor_[g].solve(load); }

  /// The local axes a contact's unknowns lie along, as rows.
  static Eigen::Matrix<double, N, Dim> rows(const SurfaceContact<Dim>& contact) {
    return contact_frame<Dim>(contact.normal).template topRows<N>();
  }

 private:
  /// The contacts of a grain, on which side of them it is (+1 or -1), and how many unknowns each has.
  struct Sides {
    Array<Index> contact;
    Array<double> sign;
    Array<int> n_rows;

    /// visit(contact, sign, first row, n_rows)
    template <class Visit>
    void for_each(Visit visit) const {
      for (Index k = 0, row = 0; k < contact.size(); row += n_rows[k++])
        visit(contact[k], sign[k], row, n_rows[k]);
    }
  };

  /// u = W r, contacts -> nodes -> T^-1 -> contacts: the factors of a grain that is well pressed are smaller
  /// than its part of W.
  void apply(const Eigen::VectorXd& r, Eigen::VectorXd& u) const {
    Array<Eigen::VectorXd> moved(pull_.size());
    parallel_for(threads, moved.size(), [&](Index g) {
      Eigen::VectorXd load = Eigen::VectorXd::Zero(pull_[g].rows());
      spread_.add_pull(g, r, 1, load);
      moved[g] = solve(g, load);
    });
    u.setZero(r.size());
    spread_.add_motion([&](Index g) -> const Eigen::VectorXd& { return moved[g]; }, u);
  }

  Array<BlockCholesky<Dim>> factor_;
  Array<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> pull_;  ///< L^-1 H^T, L^-1 R0
  Array<Sides> sides_;
  ContactSpread<Dim, N> spread_;
};

}  // namespace jampack
