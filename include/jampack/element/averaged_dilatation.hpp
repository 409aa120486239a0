// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cstddef>
#include <jampack/core/array.hpp>
#include <jampack/core/error.hpp>
#include <jampack/element/definite.hpp>
#include <jampack/material/material.hpp>
#include <limits>

namespace jampack {

/// A patch of integration points that share one averaged dilatation (docs/theory/elements.md, eq. 3):
///   E(x) = sum_q V_q psi_d(F_q) + V U(v / V),  V = sum_q V_q,  v = sum_q V_q J_q.
/// All simplices of this library are of this form; they differ in points and shape functions. Each point sees
/// `NSupport` of the `NNodes` nodes. Degrees of freedom are numbered Dim * local_node + axis.
template <int Dim, int NNodes, int NPoints, int NSupport>
struct AveragedDilatation {
  static constexpr int n_nodes = NNodes;

  struct Point {
    double volume;                                   ///< V_q > 0
    std::array<int, NSupport> support;               ///< local nodes, ascending
    Eigen::Matrix<double, Dim, NSupport> gradients;  ///< dN_a/dX, a column a supporting node
  };
  struct Cell {
    std::array<Index, NNodes> node;
    double volume;  ///< V
    std::array<Point, NPoints> points;
  };
  using Nodal = Eigen::Matrix<double, Dim, NNodes>;
  using Tangent = Eigen::Matrix<double, Dim * NNodes, Dim * NNodes>;
  using VolumeShares = Eigen::Matrix<double, 1, NNodes>;

  /// Energy at the current nodal positions x; +infinity where a point is inverted.
  template <Material<Dim> M>
  static double energy(const Cell& cell, const M& material, const Nodal& x) {
    State state;
    if (!state.template update<M>(cell, x)) return std::numeric_limits<double>::infinity();
    double energy = cell.volume * material.volumetric(state.current_volume / cell.volume).energy;
    for (std::size_t q = 0; q < NPoints; ++q)
      energy += cell.points[q].volume * material.distortional_energy(state.at[q]);
    return energy;
  }

  /// f = dE/dx; false, and f unspecified, where a point is inverted.
  template <Material<Dim> M>
  static bool force(const Cell& cell, const M& material, const Nodal& x, Nodal& f) {
    State state;
    if (!state.template update<M>(cell, x)) return false;
    const double pressure = material.volumetric(state.current_volume / cell.volume).slope;
    f.setZero();
    for (std::size_t q = 0; q < NPoints; ++q)
      add_force<M>(cell.points[q], material, state.at[q], pressure, f);
    return true;
  }

  /// f = dE/dx and its exact, symmetric derivative k; false where a point is inverted.
  template <Material<Dim> M>
  static bool force_and_tangent(const Cell& cell, const M& material, const Nodal& x, Nodal& f, Tangent& k) {
    return linearise<false>(cell, material, x, f, k);
  }

  /// f exact, k positive semi-definite: equal to the tangent where there is no stress, and elsewhere without
  /// the geometric stiffness of pressure and with the rotational part of the distortional tangent reduced
  /// until no eigenvalue is negative (docs/theory/elements.md, eq. 7).
  template <Material<Dim> M>
  static bool force_and_definite_tangent(const Cell& cell, const M& material, const Nodal& x, Nodal& f,
                                         Tangent& k) {
    return linearise<true>(cell, material, x, f, k);
  }

  /// Smallest det F over the points.
  static double min_jacobian(const Cell& cell, const Nodal& x) {
    double smallest = std::numeric_limits<double>::infinity();
    for (const auto& point : cell.points)
      smallest = std::min(smallest, deformation_gradient(point, x).determinant());
    return smallest;
  }

  /// visit(reference volume, Cauchy stress, J) at every point of a state without inverted points.
  template <Material<Dim> M, class Visit>
  static void for_each_point(const Cell& cell, const M& material, const Nodal& x, Visit visit) {
    State state;
    state.template update<M>(cell, x);
    const double pressure = material.volumetric(state.current_volume / cell.volume).slope;
    for (std::size_t q = 0; q < NPoints; ++q) {
      Matrix<Dim> stress = material.distortional_stress(state.at[q]);
      if constexpr (M::finite_strain)
        stress = (stress * state.at[q].gradient.transpose() / state.at[q].dilatation).eval();
      stress.diagonal().array() += pressure;
      visit(cell.points[q].volume, stress, state.at[q].dilatation);
    }
  }

 protected:
  /// Completes a cell whose nodes and points are set.
  static void finish(Cell& cell) {
    cell.volume = 0;
    for (const auto& point : cell.points) {
      require(point.volume > 0, "element: the reference mesh has a cell of no or negative volume");
      cell.volume += point.volume;
    }
  }

 private:
  static Matrix<Dim> deformation_gradient(const Point& point, const Nodal& x) {
    Matrix<Dim> gradient = Matrix<Dim>::Zero();
    for (int a = 0; a < NSupport; ++a)
      gradient.noalias() +=
          x.col(point.support[static_cast<std::size_t>(a)]) * point.gradients.col(a).transpose();
    return gradient;
  }

  struct State {
    std::array<Deformation<Dim>, NPoints> at;
    double current_volume;

    template <class M>
    bool update(const Cell& cell, const Nodal& x) {
      current_volume = 0;
      for (std::size_t q = 0; q < NPoints; ++q) {
        at[q].gradient = deformation_gradient(cell.points[q], x);
        if constexpr (M::finite_strain) {
          at[q].dilatation = at[q].gradient.determinant();
          if (!(at[q].dilatation > 0)) return false;
          at[q].inverse_transpose = at[q].gradient.inverse().transpose();
        } else {
          at[q].dilatation = 1 + at[q].gradient.trace() - Dim;
        }
        current_volume += cell.points[q].volume * at[q].dilatation;
      }
      return true;
    }
  };

  /// dJ/dx_a = (J F^-T) G_a at finite strain, G_a at small strain.
  template <class M>
  static Matrix<Dim> dilatation_slope(const Deformation<Dim>& at) {
    if constexpr (M::finite_strain)
      return at.dilatation * at.inverse_transpose;
    else
      return Matrix<Dim>::Identity();
  }

  template <class M>
  static void add_force(const Point& point, const M& material, const Deformation<Dim>& at, double pressure,
                        Nodal& f) {
    const Matrix<Dim> stress =
        point.volume * (material.distortional_stress(at) + pressure * dilatation_slope<M>(at));
    for (int a = 0; a < NSupport; ++a)
      f.col(point.support[static_cast<std::size_t>(a)]).noalias() += stress * point.gradients.col(a);
  }

  template <bool Definite, class M>
  static bool linearise(const Cell& cell, const M& material, const Nodal& x, Nodal& f, Tangent& k) {
    State state;
    if (!state.template update<M>(cell, x)) return false;
    const VolumetricResponse volumetric = material.volumetric(state.current_volume / cell.volume);
    f.setZero();
    k.setZero();  // its lower triangle of blocks is summed first
    Eigen::Matrix<double, Dim * NNodes, 1> volume_slope = Eigen::Matrix<double, Dim * NNodes, 1>::Zero();
    for (std::size_t q = 0; q < NPoints; ++q) {
      const Point& point = cell.points[q];
      const Deformation<Dim>& at = state.at[q];
      add_force<M>(point, material, at, volumetric.slope, f);
      Eigen::Matrix<double, Dim, NSupport> spatial = point.gradients;
      if constexpr (M::finite_strain) spatial = at.inverse_transpose * point.gradients;
      const double dilated = M::finite_strain ? point.volume * at.dilatation : point.volume;
      for (int a = 0; a < NSupport; ++a)
        volume_slope.template segment<Dim>(Dim * point.support[static_cast<std::size_t>(a)]) +=
            dilated * spatial.col(a);
      // d2J / dx_a dx_b = J (g_a g_b^T - g_b g_a^T)
      const double geometric = M::finite_strain && !Definite ? volumetric.slope * dilated : 0;
      if constexpr (HasGradientTangent<M, Dim>) {
        GradientTangent tangent = material.distortional_tangent(at);
        double rotational = 0;
        if constexpr (Definite && M::finite_strain) rotational = make_definite(tangent, at);
        add_tangent(point, spatial, point.volume * tangent.isotropic, point.volume * rotational, geometric,
                    point.volume * tangent.exchange - geometric, k);
      } else {
        MatrixTangent<Dim> tangent = material.distortional_tangent(at);
        if constexpr (Definite) make_definite<Dim>(tangent);
        add_tangent(point, MatrixTangent<Dim>(point.volume * tangent), k);
        if (geometric != 0) add_tangent(point, spatial, 0, 0, geometric, -geometric, k);
      }
    }
    const double curvature = Definite ? std::max(volumetric.curvature, 0.0) : volumetric.curvature;
    for (int j = 0; j < Dim * NNodes; ++j) {
      const double factor = curvature / cell.volume * volume_slope[j];
      for (int i = j; i < Dim * NNodes; ++i) k(i, j) += factor * volume_slope[i];
    }
    k.template triangularView<Eigen::StrictlyUpper>() = k.transpose();
    return true;
  }

  /// k_ab += (isotropic G_a . G_b + rotational g_a . g_b) I + dyadic g_a g_b^T + exchange g_b g_a^T, a >= b
  static void add_tangent(const Point& point, const Eigen::Matrix<double, Dim, NSupport>& spatial,
                          double isotropic, double rotational, double dyadic, double exchange, Tangent& k) {
    for (int b = 0; b < NSupport; ++b) {
      const Vector<Dim> ga = dyadic * spatial.col(b), gb = exchange * spatial.col(b);
      const Vector<Dim> scaled = isotropic * point.gradients.col(b), turned = rotational * spatial.col(b);
      const int column = Dim * point.support[static_cast<std::size_t>(b)];
      for (int a = b; a < NSupport; ++a) {
        const int row = Dim * point.support[static_cast<std::size_t>(a)];
        const double diagonal = point.gradients.col(a).dot(scaled) + spatial.col(a).dot(turned);
        for (int j = 0; j < Dim; ++j) {
          for (int i = 0; i < Dim; ++i)
            k(row + i, column + j) += spatial(i, a) * ga[j] + gb[i] * spatial(j, a);
          k(row + j, column + j) += diagonal;
        }
      }
    }
  }

  /// k_ab += G_a . tangent . G_b for a tangent given as a matrix, a >= b
  static void add_tangent(const Point& point, const MatrixTangent<Dim>& tangent, Tangent& k) {
    for (int b = 0; b < NSupport; ++b) {
      Eigen::Matrix<double, Dim * Dim, Dim> half = Eigen::Matrix<double, Dim * Dim, Dim>::Zero();
      for (int l = 0; l < Dim; ++l) half += point.gradients(l, b) * tangent.template middleCols<Dim>(Dim * l);
      const int column = Dim * point.support[static_cast<std::size_t>(b)];
      for (int a = b; a < NSupport; ++a) {
        const int row = Dim * point.support[static_cast<std::size_t>(a)];
        for (int j = 0; j < Dim; ++j)
          k.template block<Dim, Dim>(row, column) +=
              point.gradients(j, a) * half.template middleRows<Dim>(Dim * j);
      }
    }
  }
};

}  // namespace jampack
