// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <jampack/mesh/mesh.hpp>
#include <jampack/mesh/quality.hpp>
#include <limits>
#include <map>
#include <utility>

namespace jampack {

/// Local nodes of the linear cells into which a macro is refined: the corner cells, then the middle triangle,
/// or the octahedron cut in four along its diagonal 0 (01-23), 1 (12-03) or 2 (20-13).
template <int Dim>
constexpr std::array<std::array<int, Dim + 1>, Mesh<Dim>::n_cells_a_macro> macro_refinement(
    int diagonal = 0) {
  if constexpr (Dim == 2) {
    return {{{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}}};
  } else {
    // Diagonal d joins mid node d to the mid node of the opposite edge; the other four mid nodes go round it.
    constexpr std::array<std::array<int, 2>, 3> axis{{{4, 9}, {5, 7}, {6, 8}}};
    constexpr std::array<std::array<int, 4>, 3> ring{{{5, 6, 7, 8}, {6, 4, 8, 9}, {4, 5, 9, 7}}};
    const auto d = static_cast<std::size_t>(diagonal);
    std::array<std::array<int, 4>, 8> cells{{{0, 4, 6, 7}, {4, 1, 5, 8}, {6, 5, 2, 9}, {7, 8, 9, 3}}};
    for (std::size_t i = 0; i < 4; ++i)
      cells[4 + i] = {axis[d][0], axis[d][1], ring[d][i], ring[d][(i + 1) % 4]};
    return cells;
  }
}

/// The linear cells of one macro; in 3D along the diagonal whose worst cell has the best radius ratio.
template <int Dim, class Nodes>
std::array<std::array<Index, Dim + 1>, Mesh<Dim>::n_cells_a_macro> refine_macro(
    const Nodes& nodes, const std::array<Index, Mesh<Dim>::n_macro_nodes>& macro) {
  std::array<std::array<Index, Dim + 1>, Mesh<Dim>::n_cells_a_macro> best{};
  double best_ratio = -std::numeric_limits<double>::infinity();
  for (int diagonal = 0; diagonal < (Dim == 2 ? 1 : 3); ++diagonal) {
    const auto local = macro_refinement<Dim>(diagonal);
    auto cells = best;
    double worst = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < local.size(); ++c) {
      for (std::size_t i = 0; i <= Dim; ++i) cells[c][i] = macro[static_cast<std::size_t>(local[c][i])];
      worst = std::min(worst, radius_ratio<Dim>(nodes, cells[c]));
    }
    if (worst > best_ratio) {
      best_ratio = worst;
      best = cells;
    }
  }
  return best;
}

/// Turns simplices into macros: `middle(a, b)` makes the mid node of edge ab and returns its index, once an
/// edge.
template <int Dim, class Middle>
Array<std::array<Index, Mesh<Dim>::n_macro_nodes>> add_mid_nodes(
    const Array<std::array<Index, Dim + 1>>& simplices, Middle middle) {
  std::map<std::pair<Index, Index>, Index> known;
  Array<std::array<Index, Mesh<Dim>::n_macro_nodes>> macros;
  macros.reserve(simplices.size());
  for (const auto& simplex : simplices) {
    std::array<Index, Mesh<Dim>::n_macro_nodes> macro{};
    std::copy(simplex.begin(), simplex.end(), macro.begin());
    for (std::size_t e = 0; e < macro_edges<Dim>.size(); ++e) {
      const Index a = simplex[static_cast<std::size_t>(macro_edges<Dim>[e][0])];
      const Index b = simplex[static_cast<std::size_t>(macro_edges<Dim>[e][1])];
      const auto [edge, is_new] = known.try_emplace(std::minmax(a, b), Index{0});
      if (is_new) edge->second = middle(a, b);
      macro[Dim + 1 + e] = edge->second;
    }
    macros.push_back(macro);
  }
  return macros;
}

/// Refines every macro into its linear cells, macro after macro.
template <int Dim, class Nodes>
Array<std::array<Index, Dim + 1>> refine_macros(
    const Nodes& nodes, const Array<std::array<Index, Mesh<Dim>::n_macro_nodes>>& macros) {
  Array<std::array<Index, Dim + 1>> cells;
  cells.reserve(macros.size() * Mesh<Dim>::n_cells_a_macro);
  for (const auto& macro : macros)
    for (const auto& cell : refine_macro<Dim>(nodes, macro)) cells.push_back(cell);
  return cells;
}

}  // namespace jampack
