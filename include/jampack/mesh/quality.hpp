// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <jampack/mesh/mesh.hpp>
#include <limits>
#include <utility>

namespace jampack {

/// Radius ratio of a simplex, Dim times inradius over circumradius: 1 when regular, 0 when flat, negative
/// when inverted.
template <int Dim, class Nodes>
double radius_ratio(const Nodes& nodes, const std::array<Index, Dim + 1>& cell) {
  const Vector<Dim>& origin = nodes[cell[0]];
  Matrix<Dim> edges;  // rows: edge vectors from node 0
  for (int i = 0; i < Dim; ++i) edges.row(i) = nodes[cell[static_cast<std::size_t>(i + 1)]] - origin;
  const double determinant = edges.determinant();
  if (!(std::abs(determinant) > 0)) return 0;
  // The circumcentre is as far from the origin as from the other corners: edges * c = |edges|^2 / 2.
  const Matrix<Dim> inverse = edges.inverse();
  const double circumradius = (inverse * (0.5 * edges.rowwise().squaredNorm())).norm();
  // The gradient of a barycentric coordinate has length 1 / height, and the inradius is 1 / sum(1 / height).
  double sum = inverse.rowwise().sum().norm();
  for (int i = 0; i < Dim; ++i) sum += inverse.col(i).norm();
  return std::copysign(Dim / (sum * circumradius), determinant);
}

/// Shape of the cells of a mesh.
struct MeshQuality {
  double min_radius_ratio;     ///< over linear cells; 1 is a regular simplex
  double mean_radius_ratio;    ///< over linear cells
  double min_scaled_jacobian;  ///< over macros: smallest over largest Jacobian at corners and mid nodes; 1 if
                               ///< affine
};

/// Jacobian determinant of the quadratic map of a macro at the barycentric point `lambda`.
template <int Dim, class Nodes>
double macro_jacobian(const Nodes& nodes, const std::array<Index, Mesh<Dim>::n_macro_nodes>& macro,
                      const Eigen::Matrix<double, Dim + 1, 1>& lambda) {
  Eigen::Matrix<double, Dim, Dim + 1> derivative;  // of the position by each barycentric coordinate
  for (int i = 0; i <= Dim; ++i)
    derivative.col(i) = (4 * lambda[i] - 1) * nodes[macro[static_cast<std::size_t>(i)]];
  for (std::size_t e = 0; e < macro_edges<Dim>.size(); ++e) {
    const auto [a, b] = macro_edges<Dim>[e];
    const Vector<Dim>& mid = nodes[macro[Dim + 1 + e]];
    derivative.col(a) += 4 * lambda[b] * mid;
    derivative.col(b) += 4 * lambda[a] * mid;
  }
  Matrix<Dim> jacobian;
  for (int i = 0; i < Dim; ++i) jacobian.col(i) = derivative.col(i + 1) - derivative.col(0);
  return jacobian.determinant();
}

/// Smallest and largest Jacobian determinant of a macro at its corners and mid nodes.
template <int Dim, class Nodes>
std::pair<double, double> macro_jacobian_range(const Nodes& nodes,
                                               const std::array<Index, Mesh<Dim>::n_macro_nodes>& macro) {
  using Barycentric = Eigen::Matrix<double, Dim + 1, 1>;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::pair<double, double> range{infinity, -infinity};
  const auto visit = [&](const Barycentric& lambda) {
    const double jacobian = macro_jacobian<Dim>(nodes, macro, lambda);
    range = {std::min(range.first, jacobian), std::max(range.second, jacobian)};
  };
  for (int i = 0; i <= Dim; ++i) visit(Barycentric::Unit(i));
  for (const auto& [a, b] : macro_edges<Dim>) visit(0.5 * (Barycentric::Unit(a) + Barycentric::Unit(b)));
  return range;
}

/// Quality of a mesh; the macro figure is 1 where there are no macros.
template <int Dim>
MeshQuality mesh_quality(const Mesh<Dim>& mesh) {
  MeshQuality quality{std::numeric_limits<double>::infinity(), 0, 1};
  for (const auto& cell : mesh.cells) {
    const double ratio = radius_ratio<Dim>(mesh.nodes, cell);
    quality.min_radius_ratio = std::min(quality.min_radius_ratio, ratio);
    quality.mean_radius_ratio += ratio / static_cast<double>(mesh.cells.size());
  }
  for (const auto& macro : mesh.macros) {
    const auto [smallest, largest] = macro_jacobian_range<Dim>(mesh.nodes, macro);
    quality.min_scaled_jacobian = std::min(quality.min_scaled_jacobian, smallest / largest);
  }
  return quality;
}

}  // namespace jampack
