// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/body/block_cholesky.hpp>
#include <jampack/body/soft_packing.hpp>
#include <jampack/core/parallel.hpp>
#include <jampack/detection/surface_contact.hpp>

namespace jampack {

/// The linear system of one Newton iteration on a packing (docs/theory/deformable_stage.md, eq. 9):
///   A = T + sum_c H_c^T G_c H_c,   T = theta K + M / (theta h^2) grain by grain,
/// with G_c the derivative of the contact force, unsymmetric where friction slips, or its symmetric part with
/// the friction bounds held. The preconditioner, symmetric and positive definite, adds a coarse solve on the
/// grains' affine motions to one Cholesky factor a grain, of T with the grain's own contact stiffness.
template <class Packing>
class NewtonSystem {
 public:
  static constexpr int Dim = Packing::dimension;
  using Model = typename Packing::Model;
  using Nodal = typename Packing::Nodal;
  static constexpr int n_modes = Dim + Dim * Dim;  ///< affine motions of a grain

  /// Linearised contact: `stiffness` = -d force / d (relative displacement), in global axes; `definite` is a
  /// symmetric positive semi-definite stand-in for it.
  struct Coupling {
    std::array<std::int32_t, 2> body{-1, -1};  ///< candidate, antagonist (-1: wall)
    std::array<std::int32_t, 2> n_nodes{0, 0};
    std::array<std::array<std::int32_t, max_face_nodes<Dim>>, 2> node{};
    std::array<std::array<double, max_face_nodes<Dim>>, 2> weight{};  ///< negative on the antagonist
    Matrix<Dim> stiffness;
    Matrix<Dim> definite;
  };

  Threads threads;
  bool symmetric = false;  ///< apply() takes the definite stand-ins of contact stiffness
  Array<Coupling> couplings;

  /// Of this packing, with T of each grain. What it is given is read whenever it works.
  void begin(const Packing& packing, const Array<BlockMatrix<Dim>>& tangent) {
    packing_ = &packing;
    tangent_ = &tangent;
    n_ = Dim * packing.n_nodes();
    if (factor_.size() != packing.grains.size()) {
      factor_.clear();
      for (Index g = 0; g < packing.grains.size(); ++g)
        factor_.emplace_back().analyse(packing.model->cholesky);
    }
    own_.resize(packing.grains.size());
  }

  void add(const typename Boundary<Dim>::Sample& sample, const SurfaceContact<Dim>& contact,
           const Matrix<Dim>& stiffness, const Matrix<Dim>& definite) {
    auto& c = couplings.emplace_back();
    c.stiffness = stiffness;
    c.definite = definite;
    c.body[0] = static_cast<std::int32_t>(contact.candidate);
    c.n_nodes[0] = static_cast<std::int32_t>(sample.n);
    for (std::size_t i = 0; i < std::size_t(sample.n); ++i) {
      c.node[0][i] = static_cast<std::int32_t>(sample.node[i]);
      c.weight[0][i] = sample.weight[Index(i)];
    }
    if (contact.is_wall()) return;
    c.body[1] = static_cast<std::int32_t>(contact.antagonist);
    c.n_nodes[1] = static_cast<std::int32_t>(contact.n_nodes);
    for (std::size_t i = 0; i < std::size_t(contact.n_nodes); ++i) {
      c.node[1][i] = static_cast<std::int32_t>(contact.node[i]);
      c.weight[1][i] = -contact.weight[Index(i)];
    }
  }

  /// To be called when tangents and couplings are complete.
  void finish() {
    sides_.assign(packing_->grains.size(), {});
    for (Index c = 0; c < couplings.size(); ++c)
      for (int side = 0; side < 2; ++side)
        if (couplings[c].body[std::size_t(side)] >= 0)
          sides_[couplings[c].body[std::size_t(side)]].push_back({c, side});
    pull_.resize(couplings.size());
  }

  /// Factorises every grain with its own contacts. Where the sum is not positive definite (a grain near a
  /// geometric instability) `stand_in(g, t)` writes a positive semi-definite T to take instead: that changes
  /// the preconditioner only.
  template <class StandIn>
  void factorise(StandIn stand_in) {
    const auto& pattern = packing_->model->pattern;
    parallel_for(threads, packing_->grains.size(), [&](Index g) {
      auto& own = own_[g];
      own = (*tangent_)[g];
      for (const auto& [c, side] : sides_[g]) add_own_stiffness(pattern, couplings[c], side, own);
      if (factor_[g].factorise(own)) return;
      stand_in(g, own);
      for (const auto& [c, side] : sides_[g]) add_own_stiffness(pattern, couplings[c], side, own);
      if (!factor_[g].factorise(own))
        throw NotConverged("the tangent of grain " + std::to_string(g) + " is not finite");
    });
  }

  /// The coarse operator on the affine motions of all grains, about the positions given; raised by a multiple
  /// of the identity where it is not positive definite.
  void coarsen(const Array<Nodal>& positions) {
    const Index n_grains = packing_->grains.size();
    const auto& pattern = packing_->model->pattern;
    modes_.resize(n_grains);
    Eigen::MatrixXd coarse = Eigen::MatrixXd::Zero(n_modes * n_grains, n_modes * n_grains);
    Array<Eigen::Matrix<double, n_modes, n_modes>> own(n_grains);
    parallel_for(threads, n_grains, [&](Index g) {
      const auto& x = positions[g];
      const Vector<Dim> centre = x.rowwise().mean();
      auto& z = modes_[g];
      z.setZero(n_, n_modes);
      const double scale = 2 / packing_->grains[g].diameter;
      for (Index i = 0; i < x.cols(); ++i)
        for (int axis = 0; axis < Dim; ++axis) {
          z(Dim * i + axis, axis) = 1;
          for (int k = 0; k < Dim; ++k)
            z(Dim * i + axis, Dim + Dim * k + axis) = scale * (x(k, i) - centre[k]);
        }
      Eigen::MatrixXd product = Eigen::MatrixXd::Zero(n_, n_modes);
      for (int m = 0; m < n_modes; ++m)
        (*tangent_)[g].add_product(pattern, z.col(m).data(), product.col(m).data());
      own[g] = z.transpose() * product;
    });
    for (Index g = 0; g < n_grains; ++g) coarse.block<n_modes, n_modes>(n_modes * g, n_modes * g) = own[g];
    for (const auto& c : couplings) {
      std::array<Eigen::Matrix<double, Dim, n_modes>, 2> row;
      for (std::size_t s = 0; s < 2; ++s) {
        row[s].setZero();
        if (c.body[s] < 0) continue;
        for (std::size_t i = 0; i < std::size_t(c.n_nodes[s]); ++i)
          row[s] += c.weight[s][i] * modes_[c.body[s]].template middleRows<Dim>(Dim * c.node[s][i]);
      }
      for (std::size_t s = 0; s < 2; ++s)
        for (std::size_t t = 0; t < 2; ++t)
          if (c.body[s] >= 0 && c.body[t] >= 0)
            coarse.block<n_modes, n_modes>(n_modes * c.body[s], n_modes * c.body[t]) +=
                row[s].transpose() * (c.definite * row[t]);
    }
    const double mean = coarse.diagonal().cwiseAbs().mean();
    for (double shift = 1e-3; coarse_.compute(coarse).info() != Eigen::Success; shift *= 4)
      coarse.diagonal().array() += shift * mean;
  }

  /// y = A x.
  void apply(const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
    y.setZero(x.size());
    const auto& pattern = packing_->model->pattern;
    parallel_for(threads, packing_->grains.size(),
                 [&](Index g) { (*tangent_)[g].add_product(pattern, x.data() + n_ * g, y.data() + n_ * g); });
    // Pulls first, one a coupling; then every grain gathers its own: no two threads write to one place.
    constexpr Index chunk = 256;
    parallel_for(threads, (couplings.size() + chunk - 1) / chunk, [&](Index k) {
      const Index end = std::min(couplings.size(), (k + 1) * chunk);
      for (Index c = k * chunk; c < end; ++c) {
        const auto& coupling = couplings[c];
        Vector<Dim> relative = Vector<Dim>::Zero();
        for (std::size_t s = 0; s < 2; ++s)
          for (std::size_t i = 0; i < std::size_t(coupling.n_nodes[s]); ++i)
            relative += coupling.weight[s][i] *
                        x.template segment<Dim>(n_ * coupling.body[s] + Dim * coupling.node[s][i]);
        pull_[c].noalias() = (symmetric ? coupling.definite : coupling.stiffness) * relative;
      }
    });
    parallel_for(threads, packing_->grains.size(), [&](Index g) {
      double* base = y.data() + n_ * g;
      for (const auto& [c, side] : sides_[g]) {
        const auto& coupling = couplings[c];
        const auto s = std::size_t(side);
        for (std::size_t i = 0; i < std::size_t(coupling.n_nodes[s]); ++i)
          Eigen::Map<Vector<Dim>>(base + Dim * coupling.node[s][i]) += coupling.weight[s][i] * pull_[c];
      }
    });
  }

  /// z close to A^-1 r: the coarse solution and those grain by grain, added.
  void precondition(const Eigen::VectorXd& r, Eigen::VectorXd& z) const {
    const Index n_grains = packing_->grains.size();
    Eigen::VectorXd coarse(n_modes * n_grains);
    for (Index g = 0; g < n_grains; ++g)
      coarse.segment<n_modes>(n_modes * g) = modes_[g].transpose() * r.segment(n_ * g, n_);
    coarse = coarse_.solve(coarse);
    z.resize(r.size());
    for (Index g = 0; g < n_grains; ++g)
      z.segment(n_ * g, n_).noalias() = modes_[g] * coarse.segment<n_modes>(n_modes * g);
    parallel_for(threads, n_grains,
                 [&](Index g) { z.segment(n_ * g, n_) += factor_[g].solve(r.segment(n_ * g, n_)); });
  }

 private:
  static void add_own_stiffness(const BlockPattern& pattern, const Coupling& c, int side,
                                BlockMatrix<Dim>& own) {
    const auto s = std::size_t(side);
    for (std::size_t i = 0; i < std::size_t(c.n_nodes[s]); ++i)
      for (std::size_t j = 0; j < std::size_t(c.n_nodes[s]); ++j)
        own.block[pattern.position(c.node[s][i], c.node[s][j])] +=
            c.weight[s][i] * c.weight[s][j] * c.definite;
  }

  const Packing* packing_ = nullptr;
  const Array<BlockMatrix<Dim>>* tangent_ = nullptr;
  Index n_ = 0;  ///< dofs of one grain
  Array<BlockMatrix<Dim>> own_;
  Array<BlockCholesky<Dim>> factor_;
  Array<Eigen::Matrix<double, Eigen::Dynamic, n_modes>> modes_;
  Eigen::LLT<Eigen::MatrixXd> coarse_;
  Array<Array<std::pair<Index, int>>> sides_;
  mutable Array<Vector<Dim>> pull_;
};

}  // namespace jampack
