// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Cholesky>
#include <array>
#include <jampack/core/error.hpp>
#include <jampack/element/averaged_dilatation.hpp>
#include <jampack/element/macro_simplex.hpp>
#include <jampack/element/shape_gradients.hpp>
#include <jampack/mesh/mesh.hpp>
#include <string_view>

namespace jampack {

/// Composite simplex (after Thoutireddy, Molinari, Repetto and Ortiz 2002, and Ostien, Foulk, Mota and
/// Veilleux 2016): displacement linear on the 4 | 8 linear cells of a macro, deformation gradient their
/// projection on the linear functions of the whole macro, one averaged dilatation. Softer than MacroSimplex,
/// whose gradients are what is projected, at half the points (docs/theory/elements.md, eq. 6).
template <int Dim>
struct CompositeSimplex
    : AveragedDilatation<Dim, Mesh<Dim>::n_macro_nodes, Dim + 1, Mesh<Dim>::n_macro_nodes> {
  using Base = AveragedDilatation<Dim, Mesh<Dim>::n_macro_nodes, Dim + 1, Mesh<Dim>::n_macro_nodes>;
  using typename Base::Cell;

  static constexpr std::string_view name = "composite";
  static constexpr bool linear_on_parts = true;

  /// One cell for each macro of the mesh; throws InvalidInput if the mesh has none.
  static Array<Cell> cells(const Mesh<Dim>& mesh, double diameter, const Matrix<Dim>& rotation) {
    require(!mesh.macros.empty(), "element composite: the mesh has no quadratic simplices");
    Array<Cell> cells;
    cells.reserve(mesh.macros.size());
    for (const auto& macro : MacroSimplex<Dim>::cells(mesh, diameter, rotation)) {
      // With barycentric coordinates lambda of the macro, the projection sum_A lambda_A Gbar_A has
      //   sum_B M_AB Gbar_B = sum_e G_e int_e lambda_A,  M_AB = int lambda_A lambda_B.
      Square mass = Square::Zero();
      Column integral = Column::Zero();
      std::array<Gradients, Dim + 1> right_side;
      right_side.fill(Gradients::Zero());
      for (const auto& part : macro.points) {
        const Square corners = barycentric(part.support);  // a corner of the linear cell a column
        const Column centre = corners.rowwise().mean();
        mass += part.volume / ((Dim + 1) * (Dim + 2)) *
                (corners * corners.transpose() + (Dim + 1) * (Dim + 1) * centre * centre.transpose());
        integral += part.volume * centre;
        for (std::size_t i = 0; i <= Dim; ++i)
          for (int a = 0; a <= Dim; ++a)
            right_side[i].col(part.support[static_cast<std::size_t>(a)]) +=
                part.volume * centre[static_cast<int>(i)] * part.gradients.col(a);
      }
      const Square inverse = mass.llt().solve(Square::Identity());
      // Points of the quadratic rule, their weights such that linear functions have their exact integrals.
      const auto rule = quadratic_rule<Dim>();
      Square values;  // lambda at a point, a point a column
      for (int q = 0; q <= Dim; ++q) values.col(q) = rule.points[static_cast<std::size_t>(q)];
      const Column weights = values.partialPivLu().solve(integral);
      Cell& cell = cells.emplace_back();
      cell.node = macro.node;
      for (int q = 0; q <= Dim; ++q) {
        auto& point = cell.points[static_cast<std::size_t>(q)];
        for (int a = 0; a < Base::n_nodes; ++a) point.support[static_cast<std::size_t>(a)] = a;
        point.volume = weights[q];
        point.gradients.setZero();
        const Column share = inverse * values.col(q);
        for (int i = 0; i <= Dim; ++i) point.gradients += share[i] * right_side[static_cast<std::size_t>(i)];
      }
      Base::finish(cell);
    }
    return cells;
  }

  /// Adds each node's share of the reference volume: the diagonal of the consistent mass of the quadratic
  /// element, scaled to the cell's volume.
  static void add_volume_shares(const Cell& cell, typename Base::VolumeShares& shares) {
    typename Base::VolumeShares diagonal = Base::VolumeShares::Zero();
    const auto rule = quadratic_rule<Dim>();
    for (std::size_t q = 0; q <= Dim; ++q)
      diagonal += cell.points[q].volume * quadratic_shapes<Dim>(rule.points[q]).cwiseAbs2().transpose();
    shares += diagonal * (cell.volume / diagonal.sum());
  }

 private:
  using Square = Eigen::Matrix<double, Dim + 1, Dim + 1>;
  using Column = Eigen::Matrix<double, Dim + 1, 1>;
  using Gradients = Eigen::Matrix<double, Dim, Base::n_nodes>;

  /// Barycentric coordinates in the macro of some of its nodes, a node a column.
  static Square barycentric(const std::array<int, Dim + 1>& nodes) {
    Square coordinates = Square::Zero();
    for (std::size_t c = 0; c <= Dim; ++c) {
      const auto column = static_cast<int>(c);
      if (nodes[c] <= Dim) {
        coordinates(nodes[c], column) = 1;
      } else {
        const auto edge = static_cast<std::size_t>(nodes[c] - Dim - 1);
        for (const int corner : macro_edges<Dim>[edge]) coordinates(corner, column) = 0.5;
      }
    }
    return coordinates;
  }
};

}  // namespace jampack
