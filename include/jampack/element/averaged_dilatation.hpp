// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <jampack/core/array.hpp>
#include <jampack/core/error.hpp>
#include <jampack/element/definite.hpp>
#include <jampack/element/tangent_sum.hpp>
#include <jampack/material/material.hpp>
#include <limits>

namespace jampack {

/// What departures of the points' dilatations from their mean cost, over the shear modulus (r in
/// docs/theory/elements.md, eq. 9): nothing, or a half, which was chosen by measurement.
struct FreeDilatations {
  static constexpr double resistance = 0;
};
struct ResistedDilatations {
  static constexpr double resistance = 0.5;
};

/// A patch of integration points that share one averaged dilatation (docs/theory/elements.md, eq. 3, 9):
///   E(x) = sum_q V_q psi_d(F_q) + V U(v / V) + (r G / 2) sum_q V_q (J_q - v / V)^2,
///   V = sum_q V_q,  v = sum_q V_q J_q,  r = Departures::resistance.
/// All simplices of this library are of this form; they differ in points and shape functions. Each point sees
/// `NSupport` of the `NNodes` nodes. Degrees of freedom are numbered Dim * local_node + axis. Where r is not
/// zero the material has to be one of HasShearModulus.
template <int Dim, int NNodes, int NPoints, int NSupport, class Departures = FreeDilatations>
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
    const double mean = state.current_volume / cell.volume;
    for (std::size_t q = 0; q < NPoints; ++q) {
      const double departure = state.at[q].dilatation - mean;
      energy += cell.points[q].volume * (material.distortional_energy(state.at[q]) +
                                         0.5 * resistance(material) * departure * departure);
    }
    return energy;
  }

  /// f = dE/dx; false, and f unspecified, where a point is inverted.
  template <Material<Dim> M>
  static bool force(const Cell& cell, const M& material, const Nodal& x, Nodal& f) {
    State state;
    if (!state.template update<M>(cell, x)) return false;
    const double mean = state.current_volume / cell.volume, slope = material.volumetric(mean).slope;
    f.setZero();
    for (std::size_t q = 0; q < NPoints; ++q)
      add_force<M>(cell.points[q], material, state.at[q],
                   slope + resistance(material) * (state.at[q].dilatation - mean), f);
    return true;
  }

  /// f = dE/dx and its exact, symmetric derivative k; false where a point is inverted.
  template <Material<Dim> M>
  static bool force_and_tangent(const Cell& cell, const M& material, const Nodal& x, Nodal& f, Tangent& k) {
    return linearise<false>(cell, material, x, f, k);
  }

  /// f exact, k positive semi-definite: equal to the tangent where there is no stress, and elsewhere without
  /// the geometric stiffness of pressure and with the rotational part of the distortional tangent reduced
  /// until no eigenvalue is negative (docs/theory/elements.md, eq. 8).
  template <Material<Dim> M>
  static bool force_and_definite_tangent(const Cell& cell, const M& material, const Nodal& x, Nodal& f,
                                         Tangent& k) {
    return linearise<true>(cell, material, x, f, k);
  }

  /// Smallest det F over the points.
  static double min_jacobian(const Cell& cell, const Nodal& x) {
    double smallest = std::numeric_limits<double>::infinity();
    for (const auto& point : cell.points) {
      const Matrix<Dim> gradient = deformation_gradient(point, x);
      smallest = std::min(smallest, determinant(gradient, cofactors(gradient)));
    }
    return smallest;
  }

  /// visit(reference volume, Cauchy stress, J) at every point of a state without inverted points.
  template <Material<Dim> M, class Visit>
  static void for_each_point(const Cell& cell, const M& material, const Nodal& x, Visit visit) {
    State state;
    state.template update<M>(cell, x);
    const double mean = state.current_volume / cell.volume, slope = material.volumetric(mean).slope;
    for (std::size_t q = 0; q < NPoints; ++q) {
      const double pressure = slope + resistance(material) * (state.at[q].dilatation - mean);
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
  static constexpr bool all_support = NSupport == NNodes;  ///< then `support` is 0, 1, 2...
  using PointAxes = NodalAxes<Dim, NSupport>;
  using Sum = TangentSum<Dim, NNodes>;

  /// Of departures from the mean dilatation: r G.
  template <class M>
  static double resistance([[maybe_unused]] const M& material) {
    if constexpr (Departures::resistance == 0) {
      return 0;
    } else {
      static_assert(HasShearModulus<M>, "this element needs the material's shear modulus, a member shear()");
      return Departures::resistance * material.shear();
    }
  }

  static Matrix<Dim> deformation_gradient(const Point& point, const Nodal& x) {
    Matrix<Dim> gradient = Matrix<Dim>::Zero();
    for (int a = 0; a < NSupport; ++a) {
      const int node = all_support ? a : point.support[static_cast<std::size_t>(a)];
      for (int j = 0; j < Dim; ++j)
        for (int i = 0; i < Dim; ++i) gradient(i, j) += x(i, node) * point.gradients(j, a);
    }
    return gradient;
  }

  /// J F^-T = dJ/dF
  static Matrix<Dim> cofactors(const Matrix<Dim>& f) {
    Matrix<Dim> cofactor;
    if constexpr (Dim == 2) {
      cofactor << f(1, 1), -f(1, 0), -f(0, 1), f(0, 0);
    } else {
      for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 3; ++i) {
          const int p = (i + 1) % 3, q = (i + 2) % 3, r = (j + 1) % 3, s = (j + 2) % 3;
          cofactor(i, j) = f(p, r) * f(q, s) - f(p, s) * f(q, r);
        }
    }
    return cofactor;
  }

  static double determinant(const Matrix<Dim>& f, const Matrix<Dim>& cofactor) {
    double sum = 0;
    for (int i = 0; i < Dim; ++i) sum += f(i, 0) * cofactor(i, 0);
    return sum;
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
          const Matrix<Dim> cofactor = cofactors(at[q].gradient);
          at[q].dilatation = determinant(at[q].gradient, cofactor);
          if (!(at[q].dilatation > 0)) return false;
          at[q].inverse_transpose = cofactor * (1 / at[q].dilatation);
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
    for (int a = 0; a < NSupport; ++a) {
      const int node = all_support ? a : point.support[static_cast<std::size_t>(a)];
      for (int j = 0; j < Dim; ++j)
        for (int i = 0; i < Dim; ++i) f(i, node) += stress(i, j) * point.gradients(j, a);
    }
  }

  template <bool Definite, class M>
  static bool linearise(const Cell& cell, const M& material, const Nodal& x, Nodal& f, Tangent& k) {
    State state;
    if (!state.template update<M>(cell, x)) return false;
    const double mean = state.current_volume / cell.volume, resisting = resistance(material);
    const VolumetricResponse volumetric = material.volumetric(mean);
    f.setZero();
    Sum sum;
    sum.set_zero();
    Nodal volume_slope = Nodal::Zero();
    for (std::size_t q = 0; q < NPoints; ++q) {
      const Point& point = cell.points[q];
      const Deformation<Dim>& at = state.at[q];
      const double pressure = volumetric.slope + resisting * (at.dilatation - mean);
      add_force<M>(point, material, at, pressure, f);
      PointAxes reference, spatial;
      reference.set(point.gradients);
      if constexpr (M::finite_strain)
        spatial.set_product(at.inverse_transpose, reference);
      else
        spatial = reference;
      const double dilated = M::finite_strain ? point.volume * at.dilatation : point.volume;
      for (int a = 0; a < NSupport; ++a)
        for (std::size_t i = 0; i < Dim; ++i)
          volume_slope(static_cast<int>(i), point.support[static_cast<std::size_t>(a)]) +=
              dilated * spatial.axis[i][a];
      // d2J / dx_a dx_b = J (g_a g_b^T - g_b g_a^T)
      const double geometric = M::finite_strain && !Definite ? pressure * dilated : 0;
      const double departing = resisting * dilated * dilated / point.volume;  // of (dJ/dx_a) (dJ/dx_b)^T
      if constexpr (all_support) {
        add_tangent<Definite>(point, material, at, reference, spatial, geometric, departing, sum);
      } else {
        TangentSum<Dim, NSupport> part;
        part.set_zero();
        add_tangent<Definite>(point, material, at, reference, spatial, geometric, departing, part);
        sum.add(part, point.support);
      }
    }
    const double curvature = Definite ? std::max(volumetric.curvature, 0.0) : volumetric.curvature;
    typename Sum::Axes slope;
    slope.set(volume_slope);
    sum.add_square(slope, (curvature - resisting) / cell.volume);
    sum.write(k);
    return true;
  }

  template <bool Definite, class M>
  static void add_tangent(const Point& point, const M& material, const Deformation<Dim>& at,
                          const PointAxes& reference, const PointAxes& spatial, double geometric,
                          double departing, TangentSum<Dim, NSupport>& sum) {
    if constexpr (HasGradientTangent<M, Dim>) {
      GradientTangent tangent = material.distortional_tangent(at);
      double rotational = 0;
      if constexpr (Definite && M::finite_strain) rotational = make_definite(tangent, at);
      sum.add(reference, spatial, point.volume * tangent.isotropic, point.volume * rotational,
              geometric + departing, point.volume * tangent.exchange - geometric);
    } else {
      MatrixTangent<Dim> tangent = material.distortional_tangent(at);
      if constexpr (Definite) make_definite<Dim>(tangent);
      sum.add(reference, MatrixTangent<Dim>(point.volume * tangent));
      if (geometric != 0 || departing != 0)
        sum.add(reference, spatial, 0, 0, geometric + departing, -geometric);
    }
  }
};

}  // namespace jampack
