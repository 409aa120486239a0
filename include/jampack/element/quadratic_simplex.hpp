// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/core/error.hpp>
#include <jampack/element/averaged_dilatation.hpp>
#include <jampack/element/shape_gradients.hpp>
#include <jampack/mesh/mesh.hpp>
#include <string>
#include <string_view>
#include <utility>

namespace jampack {

/// Quadratic triangle or tetrahedron with curved sides and one averaged dilatation (P2 / P0), 3 | 4 points.
///
/// Four points integrate the gradients of a curved tetrahedron inexactly, which would fail the patch test; so
/// the volumes and gradients at the points are corrected to have the exact integrals
/// (docs/theory/elements.md, eq. 5).
template <int Dim, class Departures>
struct BasicQuadraticSimplex
    : AveragedDilatation<Dim, Mesh<Dim>::n_macro_nodes, Dim + 1, Mesh<Dim>::n_macro_nodes, Departures> {
  using Base =
      AveragedDilatation<Dim, Mesh<Dim>::n_macro_nodes, Dim + 1, Mesh<Dim>::n_macro_nodes, Departures>;
  using typename Base::Cell;

  static constexpr std::string_view name = Departures::resistance == 0 ? "quadratic" : "resisting";

  /// One cell for each macro of the mesh; throws InvalidInput if the mesh has none.
  static Array<Cell> cells(const Mesh<Dim>& mesh, double diameter, const Matrix<Dim>& rotation) {
    require(!mesh.macros.empty(), "element " + std::string(name) + ": the mesh has no quadratic simplices");
    Array<Cell> cells;
    cells.reserve(mesh.macros.size());
    constexpr auto n = static_cast<std::size_t>(Dim + 1);
    const SimplexRule<Dim, n> rule = quadratic_rule<Dim>();
    for (Index m = 0; m < mesh.macros.size(); ++m) {
      Cell& cell = cells.emplace_back();
      cell.node = mesh.macros[m];
      const auto positions = reference_positions(mesh, cell.node, diameter, rotation);
      double volume = 0;
      Gradients integral = Gradients::Zero();
      for (std::size_t q = 0; q < n; ++q) {
        auto& point = cell.points[q];
        for (int a = 0; a < Base::n_nodes; ++a) point.support[static_cast<std::size_t>(a)] = a;
        point.volume = quadratic_gradients<Dim>(positions, rule.points[q], point.gradients) *
                       rule.weights[q] * reference_simplex_volume<Dim>;
        volume += point.volume;
      }
      const auto [exact_volume, exact_integral] = integrate(positions);
      for (auto& point : cell.points) {
        point.volume *= exact_volume / volume;
        integral += point.volume * point.gradients;
      }
      for (auto& point : cell.points) point.gradients += (exact_integral - integral) / exact_volume;
      Base::finish(cell);
    }
    return cells;
  }

  /// Adds each node's share of the reference volume: the diagonal of the consistent mass, scaled to the
  /// cell's volume (Hinton, Rock and Zienkiewicz 1976), because row sums are negative at the corners.
  static void add_volume_shares(const Cell& cell, typename Base::VolumeShares& shares) {
    typename Base::VolumeShares diagonal = Base::VolumeShares::Zero();
    const auto rule = quadratic_rule<Dim>();
    for (std::size_t q = 0; q <= Dim; ++q)
      diagonal += cell.points[q].volume * quadratic_shapes<Dim>(rule.points[q]).cwiseAbs2().transpose();
    shares += diagonal * (cell.volume / diagonal.sum());
  }

 private:
  using Gradients = Eigen::Matrix<double, Dim, Base::n_nodes>;

  /// Volume of a curved cell and the integrals of its shape functions' gradients, exact: cubic in 3D.
  static std::pair<double, Gradients> integrate(const Gradients& positions) {
    const auto rule = cubic_rule<Dim>();
    std::pair<double, Gradients> integral{0, Gradients::Zero()};
    for (std::size_t q = 0; q < rule.weights.size(); ++q) {
      Gradients gradients;
      const double volume = quadratic_gradients<Dim>(positions, rule.points[q], gradients) * rule.weights[q] *
                            reference_simplex_volume<Dim>;
      integral.first += volume;
      integral.second += volume * gradients;
    }
    return integral;
  }
};

/// Too soft where pressure varies within a cell, since its dilatation may then vary at no cost.
template <int Dim>
using QuadraticSimplex = BasicQuadraticSimplex<Dim, FreeDilatations>;

/// Quadratic, with dilatations that depart from the cell's mean at a cost.
template <int Dim>
using ResistingSimplex = BasicQuadraticSimplex<Dim, ResistedDilatations>;

}  // namespace jampack
