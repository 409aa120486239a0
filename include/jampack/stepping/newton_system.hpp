// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/body/soft_packing.hpp>
#include <jampack/core/parallel.hpp>
#include <jampack/detection/surface_contact.hpp>

namespace jampack {

/// The linear system of one Newton iteration on a packing (docs/theory/deformable_stage.md, eq. 9):
///   A = T + sum_c H_c^T G_c H_c,   T = theta K + M / (theta h^2) grain by grain,
/// with G_c the (unsymmetric, where friction slips) derivative of the contact force. The preconditioner is
/// one Cholesky factor a grain, of T with the grain's own contact stiffness, after a coarse solve on the
/// grains' affine motions.
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
  Array<BlockMatrix<Dim>> tangent;  ///< T of each grain
  Array<Coupling> couplings;

  void resize(const Packing& packing) {
    packing_ = &packing;
    n_ = Dim * packing.n_nodes();
    tangent.resize(packing.grains.size());
    if (factor_.size() != packing.grains.size()) {
      factor_.clear();
      for (Index g = 0; g < packing.grains.size(); ++g)
        factor_.emplace_back().analyse(packing.model->pattern);
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
  /// geometric instability) a growing multiple of its mass is added: that changes the preconditioner only.
  void factorise() {
    const auto& pattern = packing_->model->pattern;
    parallel_for(threads, packing_->grains.size(), [&](Index g) {
      auto& own = own_[g];
      own = tangent[g];
      for (const auto& [c, side] : sides_[g]) add_own_stiffness(pattern, couplings[c], side, own);
      double mean_diagonal = 0;
      for (Index i = 0; i < pattern.n_rows(); ++i) mean_diagonal += own.block[pattern.position(i, i)].trace();
      mean_diagonal /= double(n_);
      for (double shift = 1e-3; !factor_[g].factorise(own); shift *= 4)
        for (Index i = 0; i < pattern.n_rows(); ++i)
          own.block[pattern.position(i, i)].diagonal().array() += shift * mean_diagonal;
    });
  }

  /// The coarse operator on the affine motions of all grains, about the positions given.
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
        tangent[g].add_product(pattern, z.col(m).data(), product.col(m).data());
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
                row[s].transpose() * (c.stiffness * row[t]);
    }
    coarse_.compute(coarse);
  }

  /// y = A x.
  void apply(const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
    y.setZero(x.size());
    const auto& pattern = packing_->model->pattern;
    parallel_for(threads, packing_->grains.size(),
                 [&](Index g) { tangent[g].add_product(pattern, x.data() + n_ * g, y.data() + n_ * g); });
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
        pull_[c].noalias() = coupling.stiffness * relative;
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

  /// z close to A^-1 r: coarse affine motions first, then grain by grain on what they leave.
  void precondition(const Eigen::VectorXd& r, Eigen::VectorXd& z) const {
    const Index n_grains = packing_->grains.size();
    Eigen::VectorXd coarse(n_modes * n_grains);
    for (Index g = 0; g < n_grains; ++g)
      coarse.segment<n_modes>(n_modes * g) = modes_[g].transpose() * r.segment(n_ * g, n_);
    coarse = coarse_.solve(coarse);
    z.resize(r.size());
    for (Index g = 0; g < n_grains; ++g)
      z.segment(n_ * g, n_).noalias() = modes_[g] * coarse.segment<n_modes>(n_modes * g);
    Eigen::VectorXd rest(r.size());
    apply(z, rest);
    rest = r - rest;
    parallel_for(threads, n_grains,
                 [&](Index g) { z.segment(n_ * g, n_) += factor_[g].solve(rest.segment(n_ * g, n_)); });
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
  Index n_ = 0;  ///< dofs of one grain
  Array<BlockMatrix<Dim>> own_;
  Array<BlockCholesky<Dim>> factor_;
  Array<Eigen::Matrix<double, Eigen::Dynamic, n_modes>> modes_;
  Eigen::PartialPivLU<Eigen::MatrixXd> coarse_;
  Array<Array<std::pair<Index, int>>> sides_;
  mutable Array<Vector<Dim>> pull_;
};

}  // namespace jampack
