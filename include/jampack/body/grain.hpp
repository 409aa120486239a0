// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/body/grain_model.hpp>
#include <limits>

namespace jampack {

/// One deformable grain: its cells and its state. Positions are the unknowns of the deformable stage.
template <class Model>
struct Grain {
  static constexpr int Dim = Model::dimension;
  using Element = typename Model::Element;
  /// Dim x n_nodes, a node a column.
  using Nodal = Eigen::Matrix<double, Dim, Eigen::Dynamic>;

  double diameter = 1;
  Matrix<Dim> rotation = Matrix<Dim>::Identity();  ///< of the reference mesh at placement
  Array<typename Element::Cell> cells;
  Eigen::VectorXd mass;  ///< lumped, a node
  Nodal position;
  Nodal velocity;

  Grain() = default;

  /// A stress-free grain at rest. Throws InvalidInput unless the diameter is positive and finite.
  Grain(const Model& model, double d, const Vector<Dim>& centre, const Matrix<Dim>& orientation)
      : diameter(d), rotation(orientation) {
    require(std::isfinite(d) && d > 0, "grain: diameter " + std::to_string(d) + " must be positive");
    cells = Element::cells(model.mesh, d, orientation);
    const Index n = model.mesh.nodes.size();
    mass = Eigen::VectorXd::Zero(n);
    for (const auto& cell : cells) {
      Eigen::Matrix<double, 1, Element::n_nodes> share = Eigen::Matrix<double, 1, Element::n_nodes>::Zero();
      Element::add_volume_shares(cell, share);
      for (int i = 0; i < Element::n_nodes; ++i)
        mass[cell.node[std::size_t(i)]] += model.material.density * share[i];
    }
    position.resize(Dim, n);
    for (Index i = 0; i < n; ++i) position.col(i) = centre + d * (orientation * model.mesh.nodes[i]);
    velocity = Nodal::Zero(Dim, n);
  }

  static typename Element::Nodal gather(const typename Element::Cell& cell, const Nodal& x) {
    typename Element::Nodal local;
    for (int i = 0; i < Element::n_nodes; ++i) local.col(i) = x.col(cell.node[std::size_t(i)]);
    return local;
  }

  /// Elastic energy at positions x; +infinity when a cell is inverted.
  double energy(const Model& model, const Nodal& x) const {
    double sum = 0;
    for (const auto& cell : cells) sum += Element::energy(cell, model.material, gather(cell, x));
    return sum;
  }

  /// Internal forces f = dE/dx at positions x; false when a cell is inverted.
  bool internal_force(const Model& model, const Nodal& x, Nodal& force) const {
    force.setZero(Dim, x.cols());
    typename Element::Nodal f;
    for (const auto& cell : cells) {
      if (!Element::force(cell, model.material, gather(cell, x), f)) return false;
      for (int i = 0; i < Element::n_nodes; ++i) force.col(cell.node[std::size_t(i)]) += f.col(i);
    }
    return true;
  }

  /// Forces as above and the exact tangent df/dx, written over `tangent`.
  bool internal_force_and_tangent(const Model& model, const Nodal& x, Nodal& force,
                                  BlockMatrix<Dim>& tangent) const {
    return linearise<false>(model, x, force, tangent);
  }

  /// Forces as above and a positive semi-definite stand-in for the tangent, equal to it without stress.
  bool internal_force_and_definite_tangent(const Model& model, const Nodal& x, Nodal& force,
                                           BlockMatrix<Dim>& tangent) const {
    return linearise<true>(model, x, force, tangent);
  }
  /// Smallest current/reference volume ratio of the cells.
  double min_jacobian(const Nodal& x) const {
    double smallest = std::numeric_limits<double>::infinity();
    for (const auto& cell : cells)
      smallest = std::min(smallest, Element::min_jacobian(cell, gather(cell, x)));
    return smallest;
  }

  Vector<Dim> centre() const { return position * mass / mass.sum(); }

 private:
  template <bool Definite>
  bool linearise(const Model& model, const Nodal& x, Nodal& force, BlockMatrix<Dim>& tangent) const {
    force.setZero(Dim, x.cols());
    tangent.set_zero(model.pattern);
    typename Element::Nodal f;
    typename Element::Tangent k;
    for (Index c = 0; c < cells.size(); ++c) {
      const auto& cell = cells[c];
      if constexpr (Definite) {
        if (!Element::force_and_definite_tangent(cell, model.material, gather(cell, x), f, k)) return false;
      } else {
        if (!Element::force_and_tangent(cell, model.material, gather(cell, x), f, k)) return false;
      }
      const auto& map = model.scatter[c];
      for (int i = 0; i < Element::n_nodes; ++i) {
        force.col(cell.node[std::size_t(i)]) += f.col(i);
        for (int j = 0; j < Element::n_nodes; ++j)
          tangent.block[map[std::size_t(i * Element::n_nodes + j)]] +=
              k.template block<Dim, Dim>(Dim * i, Dim * j);
      }
    }
    return true;
  }
};

}  // namespace jampack
