// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>
#include <cmath>
#include <jampack/element/brick.hpp>
#include <jampack/element/composite_simplex.hpp>
#include <jampack/element/linear_simplex.hpp>
#include <jampack/element/macro_simplex.hpp>
#include <jampack/element/quadratic_simplex.hpp>
#include <jampack/material/linear_elastic.hpp>
#include <jampack/material/neo_hookean.hpp>
#include <jampack/mesh/ball_mesh.hpp>
#include <jampack/mesh/brick_mesh.hpp>
#include <jampack/mesh/disk_mesh.hpp>
#include <set>

namespace jampack_tests {

using namespace jampack;

/// One body of one element and one material, assembled plainly: what the tests of elements stand on.
template <int Dim, class Element, class Material>
struct Solid {
  Mesh<Dim> mesh;
  Material material;
  Array<typename Element::Cell> cells;
  Eigen::VectorXd reference;  ///< dof = Dim * node + axis

  Solid(Mesh<Dim> of, Material made_of) : mesh(std::move(of)), material(made_of) {
    cells = Element::cells(mesh, 1.0, Matrix<Dim>::Identity());
    reference.resize(Dim * mesh.nodes.size());
    for (Index i = 0; i < mesh.nodes.size(); ++i) reference.template segment<Dim>(Dim * i) = mesh.nodes[i];
  }

  typename Element::Nodal gather(const typename Element::Cell& cell, const Eigen::VectorXd& x) const {
    typename Element::Nodal nodal;
    for (int a = 0; a < Element::n_nodes; ++a)
      nodal.col(a) = x.template segment<Dim>(Dim * cell.node[static_cast<std::size_t>(a)]);
    return nodal;
  }

  Eigen::VectorXd force(const Eigen::VectorXd& x) const {
    Eigen::VectorXd total = Eigen::VectorXd::Zero(x.size());
    for (const auto& cell : cells) {
      typename Element::Nodal f;
      if (!Element::force(cell, material, gather(cell, x), f)) throw Error("inverted");
      for (int a = 0; a < Element::n_nodes; ++a)
        total.template segment<Dim>(Dim * cell.node[static_cast<std::size_t>(a)]) += f.col(a);
    }
    return total;
  }

  Eigen::SparseMatrix<double> tangent(const Eigen::VectorXd& x) const {
    std::vector<Eigen::Triplet<double, Index>> entries;
    for (const auto& cell : cells) {
      typename Element::Nodal f;
      typename Element::Tangent k;
      if (!Element::force_and_tangent(cell, material, gather(cell, x), f, k)) throw Error("inverted");
      for (int i = 0; i < k.rows(); ++i)
        for (int j = 0; j < k.cols(); ++j)
          entries.emplace_back(Dim * cell.node[static_cast<std::size_t>(i / Dim)] + i % Dim,
                               Dim * cell.node[static_cast<std::size_t>(j / Dim)] + j % Dim, k(i, j));
    }
    Eigen::SparseMatrix<double> total(x.size(), x.size());
    total.setFromTriplets(entries.begin(), entries.end());
    return total;
  }

  Eigen::VectorXd lumped_volume() const {
    Eigen::VectorXd volume = Eigen::VectorXd::Zero(reference.size());
    for (const auto& cell : cells) {
      typename Element::VolumeShares shares = Element::VolumeShares::Zero();
      Element::add_volume_shares(cell, shares);
      for (int a = 0; a < Element::n_nodes; ++a)
        volume.template segment<Dim>(Dim * cell.node[static_cast<std::size_t>(a)]).array() += shares[a];
    }
    return volume;
  }

  double min_jacobian(const Eigen::VectorXd& x) const {
    double smallest = 1;
    for (const auto& cell : cells)
      smallest = std::min(smallest, Element::min_jacobian(cell, gather(cell, x)));
    return smallest;
  }

  /// Newton's method from x under the dead load `load`, dofs of `held` staying where x has them.
  Eigen::VectorXd equilibrium(Eigen::VectorXd x, const Eigen::VectorXd& load, const std::set<Index>& held,
                              double tolerance = 1e-11) const {
    double scale = 0;
    for (int iteration = 0; iteration < 40; ++iteration) {
      Eigen::VectorXd residual = force(x) - load;
      scale = std::max(scale, residual.norm());
      Eigen::SparseMatrix<double> k = tangent(x);
      k.prune([&](Index i, Index j, double) { return i == j || (!held.count(i) && !held.count(j)); });
      for (const Index i : held) {
        residual[i] = 0;
        k.coeffRef(i, i) = 1;
      }
      if (residual.norm() <= tolerance * scale) return x;
      const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(k);
      if (factor.info() != Eigen::Success) throw Error("singular");
      const Eigen::VectorXd step = factor.solve(residual);
      double share = 1;  // of the step that inverts no cell
      while (min_jacobian(x - share * step) <= 0) share /= 2;
      x -= share * step;
    }
    throw Error("Newton's method does not converge");
  }
};

/// All dofs of the boundary.
template <int Dim>
std::set<Index> boundary_dofs(const Mesh<Dim>& mesh) {
  std::set<Index> dofs;
  for (const Index i : mesh.boundary_nodes)
    for (int d = 0; d < Dim; ++d) dofs.insert(Dim * i + d);
  return dofs;
}

/// A small grain mesh.
template <int Dim>
Mesh<Dim> grain_mesh(Index wanted) {
  if constexpr (Dim == 2)
    return disk_mesh(wanted);
  else
    return ball_mesh(wanted);
}

/// A small grain mesh that the element can use.
template <class Element>
auto mesh_for(Index wanted) {
  constexpr int Dim = Element::Nodal::RowsAtCompileTime;
  if (Element::name == "brick") return brick_mesh<Dim>({.n_core = wanted > 150 ? 2 : 1, .n_layers = 1});
  return grain_mesh<Dim>(wanted);
}

/// Infinitesimal rigid motions at positions x, orthonormal columns: Dim translations, then rotations.
template <int Dim>
Eigen::MatrixXd rigid_motions(const Eigen::VectorXd& x) {
  constexpr int n_rotations = Dim == 2 ? 1 : 3;
  Eigen::MatrixXd motions = Eigen::MatrixXd::Zero(x.size(), Dim + n_rotations);
  for (Index i = 0; i < x.size(); i += Dim) {
    for (int d = 0; d < Dim; ++d) motions(i + d, d) = 1;
    for (int r = 0; r < n_rotations; ++r) {
      const int p = Dim == 2 ? 0 : (r + 1) % 3, q = Dim == 2 ? 1 : (r + 2) % 3;
      motions(i + p, Dim + r) = -x[i + q];
      motions(i + q, Dim + r) = x[i + p];
    }
  }
  return Eigen::HouseholderQR<Eigen::MatrixXd>(motions).householderQ() *
         Eigen::MatrixXd::Identity(x.size(), Dim + n_rotations);
}

}  // namespace jampack_tests
