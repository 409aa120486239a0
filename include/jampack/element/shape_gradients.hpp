// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <cstddef>
#include <jampack/mesh/mesh.hpp>

namespace jampack {

/// Reference positions of a cell's nodes, a column a node: rotation * diameter * mesh node.
template <int Dim, std::size_t N>
Eigen::Matrix<double, Dim, static_cast<int>(N)> reference_positions(const Mesh<Dim>& mesh,
                                                                    const std::array<Index, N>& node,
                                                                    double diameter,
                                                                    const Matrix<Dim>& rotation) {
  Eigen::Matrix<double, Dim, static_cast<int>(N)> positions;
  for (std::size_t a = 0; a < N; ++a)
    positions.col(static_cast<Index>(a)) = rotation * (diameter * mesh.nodes[node[a]]);
  return positions;
}

/// Volume of the reference simplex, 1 / Dim!
template <int Dim>
inline constexpr double reference_simplex_volume = Dim == 2 ? 1.0 / 2 : 1.0 / 6;

/// Gradients of the barycentric coordinates of a simplex, a column a corner; returns its signed volume.
template <int Dim>
double linear_gradients(const Eigen::Matrix<double, Dim, Dim + 1>& corners,
                        Eigen::Matrix<double, Dim, Dim + 1>& gradients) {
  const Matrix<Dim> edges = corners.template rightCols<Dim>().colwise() - corners.col(0);
  gradients.template rightCols<Dim>() = edges.inverse().transpose();
  gradients.col(0) = -gradients.template rightCols<Dim>().rowwise().sum();
  return edges.determinant() * reference_simplex_volume<Dim>;
}

/// Values of the quadratic shape functions (macro order of nodes) at barycentric coordinates `lambda`.
template <int Dim>
Eigen::Matrix<double, Mesh<Dim>::n_macro_nodes, 1> quadratic_shapes(
    const Eigen::Matrix<double, Dim + 1, 1>& lambda) {
  Eigen::Matrix<double, Mesh<Dim>::n_macro_nodes, 1> shapes;
  for (int a = 0; a <= Dim; ++a) shapes[a] = lambda[a] * (2 * lambda[a] - 1);
  for (std::size_t e = 0; e < macro_edges<Dim>.size(); ++e)
    shapes[Dim + 1 + static_cast<Index>(e)] =
        4 * lambda[macro_edges<Dim>[e][0]] * lambda[macro_edges<Dim>[e][1]];
  return shapes;
}

/// Gradients of the quadratic shape functions by the reference position, a column a node; returns det dX/dxi.
template <int Dim>
double quadratic_gradients(const Eigen::Matrix<double, Dim, Mesh<Dim>::n_macro_nodes>& positions,
                           const Eigen::Matrix<double, Dim + 1, 1>& lambda,
                           Eigen::Matrix<double, Dim, Mesh<Dim>::n_macro_nodes>& gradients) {
  constexpr int n = Mesh<Dim>::n_macro_nodes;
  Eigen::Matrix<double, Dim + 1, n> by_lambda = Eigen::Matrix<double, Dim + 1, n>::Zero();
  for (int a = 0; a <= Dim; ++a) by_lambda(a, a) = 4 * lambda[a] - 1;
  for (std::size_t e = 0; e < macro_edges<Dim>.size(); ++e) {
    const auto [a, b] = macro_edges<Dim>[e];
    by_lambda(a, Dim + 1 + static_cast<Index>(e)) = 4 * lambda[b];
    by_lambda(b, Dim + 1 + static_cast<Index>(e)) = 4 * lambda[a];
  }
  const Eigen::Matrix<double, Dim, n> by_xi =
      by_lambda.template bottomRows<Dim>().rowwise() - by_lambda.row(0);
  const Matrix<Dim> jacobian = positions * by_xi.transpose();
  gradients = jacobian.inverse().transpose() * by_xi;
  return jacobian.determinant();
}

/// A quadrature rule on the reference simplex: barycentric points, and weights that sum to 1.
template <int Dim, std::size_t N>
struct SimplexRule {
  std::array<Eigen::Matrix<double, Dim + 1, 1>, N> points;
  std::array<double, N> weights;
};

/// Dim + 1 interior points of equal weight, exact for quadratic polynomials.
template <int Dim>
SimplexRule<Dim, Dim + 1> quadratic_rule() {
  SimplexRule<Dim, Dim + 1> rule;
  const double near = Dim == 2 ? 2.0 / 3 : (5 + 3 * std::sqrt(5.0)) / 20;
  for (std::size_t q = 0; q <= Dim; ++q) {
    rule.points[q].setConstant((1 - near) / Dim);
    rule.points[q][static_cast<Index>(q)] = near;
    rule.weights[q] = 1.0 / (Dim + 1);
  }
  return rule;
}

/// Dim + 2 points, exact for cubic polynomials; the weight of the centre is negative, so not for energies.
template <int Dim>
SimplexRule<Dim, Dim + 2> cubic_rule() {
  SimplexRule<Dim, Dim + 2> rule;
  for (std::size_t q = 0; q <= Dim; ++q) {
    rule.points[q].setConstant(1.0 / (Dim + 3));
    rule.points[q][static_cast<Index>(q)] = 3.0 / (Dim + 3);
    rule.weights[q] = (Dim + 3.0) * (Dim + 3.0) / (4.0 * (Dim + 1) * (Dim + 2));
  }
  rule.points[Dim + 1].setConstant(1.0 / (Dim + 1));
  rule.weights[Dim + 1] = 1 - (Dim + 1) * rule.weights[0];
  return rule;
}

}  // namespace jampack
