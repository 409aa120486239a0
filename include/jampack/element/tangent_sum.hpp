// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <jampack/material/material.hpp>

namespace jampack {

/// One number for each axis and node, the nodes of an axis together and padded with zeros to a multiple of
/// four: loops over nodes are the inner ones, so that they fill vector registers whatever the dimension. All
/// arithmetic on columns goes through `add_to`, because each Eigen expression costs compile time.
template <int Dim, int N>
struct NodalAxes {
  static constexpr int n_padded = (N + 3) / 4 * 4;
  using Column = Eigen::Array<double, n_padded, 1>;
  std::array<Column, Dim> axis;

  static void add_to(Column& column, double factor, const Column& from) { column += factor * from; }

  /// From a matrix with a node a column.
  template <class Nodal>
  void set(const Nodal& nodal) {
    for (std::size_t i = 0; i < Dim; ++i)
      for (int a = 0; a < n_padded; ++a) axis[i][a] = a < N ? nodal(static_cast<int>(i), a) : 0;
  }

  /// Every node's vector of `from`, times the matrix.
  void set_product(const Matrix<Dim>& matrix, const NodalAxes& from) {
    for (std::size_t i = 0; i < Dim; ++i) {
      axis[i].setZero();
      for (std::size_t j = 0; j < Dim; ++j)
        add_to(axis[i], matrix(static_cast<int>(i), static_cast<int>(j)), from.axis[j]);
    }
  }
};

/// A symmetric tangent of N nodes while it is summed: for each pair of axes i <= j the entries
/// d2E / dx_ai dx_bj, a column for each node b.
template <int Dim, int N>
struct TangentSum {
  using Axes = NodalAxes<Dim, N>;
  using Column = typename Axes::Column;
  static constexpr std::size_t n_axis_pairs = Dim * (Dim + 1) / 2;

  std::array<std::array<Column, N>, n_axis_pairs> entry;

  void set_zero() {
    for (auto& plane : entry)
      for (auto& column : plane) column.setZero();
  }

  /// entry_ab += (isotropic G_a . G_b + rotational g_a . g_b) I + dyadic g_a g_b^T + exchange g_b g_a^T
  void add(const Axes& reference, const Axes& spatial, double isotropic, double rotational, double dyadic,
           double exchange) {
    for (int b = 0; b < N; ++b) {
      Column diagonal;
      diagonal.setZero();
      for (std::size_t l = 0; l < Dim; ++l)
        Axes::add_to(diagonal, isotropic * reference.axis[l][b], reference.axis[l]);
      if (rotational != 0)
        for (std::size_t l = 0; l < Dim; ++l)
          Axes::add_to(diagonal, rotational * spatial.axis[l][b], spatial.axis[l]);
      std::size_t pair = 0;
      for (std::size_t i = 0; i < Dim; ++i)
        for (std::size_t j = i; j < Dim; ++j, ++pair) {
          Column& column = entry[pair][static_cast<std::size_t>(b)];
          Axes::add_to(column, dyadic * spatial.axis[j][b], spatial.axis[i]);
          Axes::add_to(column, exchange * spatial.axis[i][b], spatial.axis[j]);
          if (i == j) Axes::add_to(column, 1, diagonal);
        }
    }
  }

  /// entry_ab += G_a . tangent . G_b
  void add(const Axes& reference, const MatrixTangent<Dim>& tangent) {
    for (int b = 0; b < N; ++b) {
      std::size_t pair = 0;
      for (std::size_t i = 0; i < Dim; ++i)
        for (std::size_t j = i; j < Dim; ++j, ++pair)
          for (std::size_t k = 0; k < Dim; ++k) {
            double factor = 0;
            for (std::size_t l = 0; l < Dim; ++l)
              factor += tangent(static_cast<int>(Dim * k + i), static_cast<int>(Dim * l + j)) *
                        reference.axis[l][b];
            Axes::add_to(entry[pair][static_cast<std::size_t>(b)], factor, reference.axis[k]);
          }
    }
  }

  /// entry += factor * slope slope^T
  void add_square(const Axes& slope, double factor) {
    for (int b = 0; b < N; ++b) {
      std::size_t pair = 0;
      for (std::size_t i = 0; i < Dim; ++i)
        for (std::size_t j = i; j < Dim; ++j, ++pair)
          Axes::add_to(entry[pair][static_cast<std::size_t>(b)], factor * slope.axis[j][b], slope.axis[i]);
    }
  }

  /// Adds what was summed for some of the nodes.
  template <std::size_t M>
  void add(const TangentSum<Dim, static_cast<int>(M)>& part, const std::array<int, M>& support) {
    for (std::size_t pair = 0; pair < n_axis_pairs; ++pair)
      for (std::size_t b = 0; b < M; ++b) {
        Column& column = entry[pair][static_cast<std::size_t>(support[b])];
        for (std::size_t a = 0; a < M; ++a) column[support[a]] += part.entry[pair][b][static_cast<int>(a)];
      }
  }

  /// Writes the whole matrix, degrees of freedom being Dim * node + axis; symmetric to the last digit.
  template <class Tangent>
  void write(Tangent& k) const {
    double* const out = k.data();
    constexpr int n = Dim * N;
    for (int b = 0; b < N; ++b) {
      std::size_t pair = 0;
      for (int i = 0; i < Dim; ++i)
        for (int j = i; j < Dim; ++j, ++pair) {
          // The planes of one axis are symmetric but for rounding: their lower triangles serve twice.
          const Column& column = entry[pair][static_cast<std::size_t>(b)];
          for (int a = i == j ? b : 0; a < N; ++a)
            out[(Dim * b + j) * n + Dim * a + i] = out[(Dim * a + i) * n + Dim * b + j] = column[a];
        }
    }
  }
};

}  // namespace jampack
