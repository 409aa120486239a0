// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cassert>
#include <cstdint>
#include <jampack/body/block_matrix.hpp>
#include <limits>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

namespace jampack {

/// Symbolic Cholesky factorisation of a BlockPattern, by nodes: the order of elimination, its supernodes
/// (runs of nodes eliminated together, as one dense panel) and where they meet. One serves all grains of a
/// reference mesh.
struct CholeskyStructure {
  /// Nodes `first`, ..., `first + n_pivots - 1` of the order; they couple to `n_rows` later nodes, listed in
  /// `rows` from `row_start` on, ascending.
  struct Supernode {
    std::int32_t first, n_pivots, n_rows, row_start;
    std::int32_t update_start, update_end;  ///< of its updates
  };
  /// Its elimination changes the panel of supernode `target`: in the columns of its rows `begin`, ...,
  /// `end - 1`, and there in the rows listed in `place` from `place_start` on, one for each row from `begin`.
  struct Update {
    std::int32_t target, begin, end, place_start;
  };
  /// Where a block of the pattern goes: row and column, by nodes, of the panel of a supernode.
  struct Entry {
    std::int32_t block, supernode, row, column;
  };

  Array<std::int32_t> order;  ///< node eliminated k-th
  Array<Supernode> supernodes;
  Array<std::int32_t> rows;
  Array<Update> updates;
  Array<std::int32_t> place;
  Array<Entry> entries;

  CholeskyStructure() = default;
  explicit CholeskyStructure(const BlockPattern& pattern) {
    const auto minimum_degree = fill_reducing_order(pattern);
    const auto columns = factor_columns(pattern, minimum_degree);
    amalgamate(minimum_degree, columns);
    find_updates();
    find_entries(pattern);
  }

  Index n_nodes() const { return order.size(); }
  /// Node blocks in all panels.
  Index n_blocks() const {
    Index sum = 0;
    for (const auto& s : supernodes) sum += Index(s.n_pivots) * (s.n_pivots + s.n_rows);
    return sum;
  }

 private:
  using Nodes = Array<std::int32_t>;

  /// The best of some minimum degree orders. They differ by how ties are broken, that is by how the nodes are
  /// numbered; on meshes of grains the best of them fills in some 10 % less than the first.
  static Nodes fill_reducing_order(const BlockPattern& pattern) {
    const Index n = pattern.n_rows();
    Nodes numbering(n), best;
    std::iota(numbering.begin(), numbering.end(), 0);
    std::mt19937 random(1);
    double least_fill = std::numeric_limits<double>::max();
    for (int attempt = 0; attempt < n_orders; ++attempt) {
      const Nodes order = minimum_degree_order(pattern, numbering);
      double fill = 0;
      for (const auto& column : factor_columns(pattern, order)) fill += double(column.size());
      if (fill < least_fill) least_fill = fill, best = order;
      for (Index i = n - 1; i > 0; --i)  // std::shuffle is not the same everywhere
        std::swap(numbering[i], numbering[static_cast<Index>(random() % std::uint32_t(i + 1))]);
    }
    return best;
  }

  static Nodes minimum_degree_order(const BlockPattern& pattern, const Nodes& numbering) {
    using Graph = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;
    const auto n = static_cast<int>(pattern.n_rows());
    const Nodes number = inverse(numbering);
    Graph graph(n, n);
    std::vector<Eigen::Triplet<double, int>> couplings;
    couplings.reserve(static_cast<std::size_t>(pattern.n_blocks()));
    for (int i = 0; i < n; ++i)
      for (Index k = pattern.row_start[i]; k < pattern.row_start[i + 1]; ++k)
        couplings.emplace_back(number[i], number[pattern.column[k]], 1.0);
    graph.setFromTriplets(couplings.begin(), couplings.end());
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
    Eigen::AMDOrdering<int>()(graph.selfadjointView<Eigen::Lower>(), order);
    Nodes eliminated;
    eliminated.reserve(n);
    for (int k = 0; k < n; ++k) eliminated.push_back(numbering[order.indices()[k]]);
    return eliminated;
  }

  static Nodes inverse(const Nodes& order) {
    Nodes position(order.size());
    for (Index k = 0; k < order.size(); ++k) position[order[k]] = static_cast<std::int32_t>(k);
    return position;
  }

  /// Rows below the diagonal of each column of the factor in that order, ascending; the first is the parent
  /// in the elimination tree.
  static Array<Nodes> factor_columns(const BlockPattern& pattern, const Nodes& order) {
    const Nodes position = inverse(order);
    Array<Nodes> columns(order.size());
    for (Index j = 0; j < order.size(); ++j) {
      auto& own = columns[j];  // already holds what its children left
      for (Index k = pattern.row_start[order[j]]; k < pattern.row_start[order[j] + 1]; ++k)
        if (const auto i = position[pattern.column[k]]; i > j) own.push_back(i);
      std::sort(own.begin(), own.end());
      own.erase(std::unique(own.begin(), own.end()), own.end());
      if (own.empty()) continue;
      auto& parent = columns[own[0]];
      parent.insert(parent.end(), own.begin() + 1, own.end());
    }
    return columns;
  }

  /// Time of a supernode in a solve, in node blocks. The constants are measured: what a supernode costs, and
  /// each row that it gathers and scatters.
  static double cost(Index n_pivots, Index n_rows) {
    return 20 + 2 * double(n_rows) + double(n_pivots * (n_pivots + 2 * n_rows));
  }
  static constexpr Index widest = 12;  ///< nodes of a supernode; measured
  static constexpr int n_orders = 20;  ///< tried; more of them gain little

  /// Merges columns into supernodes, child into parent, wherever that costs less than to treat them apart,
  /// the zeros that it stores included; then numbers nodes and supernodes in postorder.
  void amalgamate(const Nodes& elimination, const Array<Nodes>& columns) {
    const Index n = columns.size();
    Array<Nodes> pivots(n), children(n);
    Nodes roots;  // a supernode is known by its last column, whose rows below are its own
    for (Index j = 0; j < n; ++j) {
      pivots[j] = {static_cast<std::int32_t>(j)};
      const Index n_rows = columns[j].size();
      while (true) {
        double best = 0;
        Index chosen = -1;
        for (Index c = 0; c < children[j].size(); ++c) {
          const Index k = children[j][c];
          const double change = cost(pivots[j].size() + pivots[k].size(), n_rows) -
                                cost(pivots[j].size(), n_rows) - cost(pivots[k].size(), columns[k].size());
          if (change < best) best = change, chosen = c;
        }
        if (chosen < 0) break;
        const Index k = children[j][chosen];
        children[j].erase(children[j].begin() + chosen);
        children[j].insert(children[j].end(), children[k].begin(), children[k].end());
        pivots[j].insert(pivots[j].begin(), pivots[k].begin(), pivots[k].end());
      }
      if (columns[j].empty())
        roots.push_back(static_cast<std::int32_t>(j));
      else
        children[columns[j][0]].push_back(static_cast<std::int32_t>(j));
    }

    Nodes postorder, pending = roots;
    while (!pending.empty()) {  // parents before children, turned round below
      const auto top = pending.back();
      pending.pop_back();
      postorder.push_back(top);
      pending.insert(pending.end(), children[top].begin(), children[top].end());
    }
    std::reverse(postorder.begin(), postorder.end());

    Nodes position(n);
    for (const auto top : postorder) {
      // Wide ones are split into a chain: the inverse of a pivot block costs the cube of its width.
      const Index n_pivots = pivots[top].size(), n_parts = (n_pivots + widest - 1) / widest;
      for (Index part = 0; part < n_parts; ++part) {
        const Index begin = n_pivots * part / n_parts, end = n_pivots * (part + 1) / n_parts;
        supernodes.push_back({static_cast<std::int32_t>(order.size()), static_cast<std::int32_t>(end - begin),
                              static_cast<std::int32_t>(n_pivots - end + columns[top].size()), top, 0, 0});
        for (Index k = begin; k < end; ++k) {
          position[pivots[top][k]] = static_cast<std::int32_t>(order.size());
          order.push_back(elimination[pivots[top][k]]);
        }
      }
    }
    for (auto& s : supernodes) {
      const auto& coupled = columns[std::exchange(s.row_start, static_cast<std::int32_t>(rows.size()))];
      for (auto k = s.first + s.n_pivots; rows.size() < s.row_start + s.n_rows - coupled.size(); ++k)
        rows.push_back(k);
      for (const auto i : coupled) rows.push_back(position[i]);
      std::sort(rows.end() - coupled.size(), rows.end());
    }
  }

  Nodes supernode_of_nodes() const {
    Nodes found(n_nodes());
    for (Index s = 0; s < supernodes.size(); ++s)
      for (Index k = 0; k < supernodes[s].n_pivots; ++k)
        found[supernodes[s].first + k] = static_cast<std::int32_t>(s);
    return found;
  }

  /// Row of a node in a panel: its pivots come first.
  std::int32_t panel_row(const Supernode& s, std::int32_t node) const {
    if (node < s.first + s.n_pivots) return node - s.first;
    const auto begin = rows.begin() + s.row_start, end = begin + s.n_rows;
    const auto found = std::lower_bound(begin, end, node);
    assert(found != end && *found == node);
    return s.n_pivots + static_cast<std::int32_t>(found - begin);
  }

  void find_updates() {
    const Nodes supernode_of = supernode_of_nodes();
    for (auto& s : supernodes) {
      s.update_start = static_cast<std::int32_t>(updates.size());
      for (std::int32_t begin = 0, end; begin < s.n_rows; begin = end) {
        const auto target = supernode_of[rows[s.row_start + begin]];
        for (end = begin; end < s.n_rows && supernode_of[rows[s.row_start + end]] == target;) ++end;
        updates.push_back({target, begin, end, static_cast<std::int32_t>(place.size())});
        for (auto i = begin; i < s.n_rows; ++i)
          place.push_back(panel_row(supernodes[target], rows[s.row_start + i]));
      }
      s.update_end = static_cast<std::int32_t>(updates.size());
    }
  }

  void find_entries(const BlockPattern& pattern) {
    const Nodes position = inverse(order), supernode_of = supernode_of_nodes();
    for (Index i = 0; i < n_nodes(); ++i)
      for (Index k = pattern.row_start[i]; k < pattern.row_start[i + 1]; ++k) {
        const auto row = position[i], column = position[pattern.column[k]];
        if (row < column) continue;
        const auto s = supernode_of[column];
        entries.push_back(
            {static_cast<std::int32_t>(k), s, panel_row(supernodes[s], row), column - supernodes[s].first});
      }
  }
};

}  // namespace jampack
