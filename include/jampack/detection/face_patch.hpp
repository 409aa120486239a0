// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/geometry/face_shape.hpp>
#include <jampack/mesh/mesh.hpp>

namespace jampack {

/// Two nodal fields of a linear or quadratic face, its points and normals, as polynomials of the face
/// coordinates. They are evaluated together, each padded to a power of two rows: a register or two a
/// coefficient, and no loop over nodes, where detection spends its time.
template <int Dim>
class FacePatch {
 public:
  static constexpr int n_rows_a_field = Dim == 2 ? 2 : 4;
  using Rows = Eigen::Matrix<double, 2 * n_rows_a_field, 1>;
  using Slopes = Eigen::Matrix<double, Dim, Dim - 1>;

  /// Value and derivatives at a point of the face.
  struct Jet {
    Rows value;
    std::array<Rows, Dim - 1> slope;
    Vector<Dim> point() const { return point_of(value); }
    Vector<Dim> normal() const { return normal_of(value); }
  };

  static Vector<Dim> point_of(const Rows& rows) { return rows.template head<Dim>(); }
  static Vector<Dim> normal_of(const Rows& rows) { return rows.template segment<Dim>(n_rows_a_field); }

  template <class Nodal>
  void set_points(const BoundaryFace<Dim>& face, const Nodal& point) {
    set<0>(face, point);
  }
  template <class Nodal>
  void set_normals(const BoundaryFace<Dim>& face, const Nodal& normal) {
    set<n_rows_a_field>(face, normal);
  }

  Rows value(const FaceCoordinates<Dim>& xi) const {
    const double b = xi[0];
    if constexpr (Dim == 2) {
      return a_[0] + b * (a_[1] + b * a_[2]);
    } else {
      const double c = xi[1];
      return a_[0] + b * (a_[1] + b * a_[3] + c * a_[4]) + c * (a_[2] + c * a_[5]);
    }
  }

  std::array<Rows, Dim - 1> slope(const FaceCoordinates<Dim>& xi) const {
    const double b = xi[0];
    if constexpr (Dim == 2) {
      return {a_[1] + (2 * b) * a_[2]};
    } else {
      const double c = xi[1];
      return {a_[1] + (2 * b) * a_[3] + c * a_[4], a_[2] + b * a_[4] + (2 * c) * a_[5]};
    }
  }

  Jet jet(const FaceCoordinates<Dim>& xi) const { return {value(xi), slope(xi)}; }

  /// Derivatives of the point.
  Slopes tangent(const FaceCoordinates<Dim>& xi) const {
    const auto rows = slope(xi);
    Slopes t;
    for (int k = 0; k < Dim - 1; ++k) t.col(k) = point_of(rows[std::size_t(k)]);
    return t;
  }

  /// Cuts the face into small flat pieces and calls visit(corners) for each, corners as see(point) has them.
  template <class See, class Visit>
  void for_each_piece(See see, Visit visit) const {
    constexpr std::size_t n = 5;  // pieces a side
    if constexpr (Dim == 2) {
      const auto corner = [&](std::size_t i) -> Vector<2> {
        return see(point_of(value(FaceCoordinates<2>(double(i) / n))));
      };
      for (std::size_t i = 0; i < n; ++i) visit(std::array{corner(i), corner(i + 1)});
    } else {
      const auto corner = [&](std::size_t i, std::size_t j) -> Vector<3> {
        return see(point_of(value(FaceCoordinates<3>(double(i) / n, double(j) / n))));
      };
      std::array<Vector<3>, n + 1> row, next;
      for (std::size_t j = 0; j <= n; ++j) row[j] = corner(0, j);
      for (std::size_t i = 0; i < n; ++i, row = next) {
        for (std::size_t j = 0; i + j < n; ++j) next[j] = corner(i + 1, j);
        for (std::size_t j = 0; i + j < n; ++j) {
          visit(std::array{row[j], next[j], row[j + 1]});
          if (i + j + 1 < n) visit(std::array{next[j], next[j + 1], row[j + 1]});
        }
      }
    }
  }

 private:
  template <int Row, class Nodal>
  void set(const BoundaryFace<Dim>& face, const Nodal& field) {
    const auto node = [&](std::size_t i) -> Vector<Dim> { return field.col(face.node[i]); };
    const auto put = [&](std::size_t k, const Vector<Dim>& value) {
      a_[k].template segment<Dim>(Row) = value;
    };
    const Vector<Dim> first = node(0);
    put(0, first);
    if (face.n_nodes == Dim) {
      for (std::size_t k = 1; k < Dim; ++k) put(k, node(k) - first);
      for (std::size_t k = Dim; k < n_coefficients; ++k) put(k, Vector<Dim>::Zero());
    } else if constexpr (Dim == 2) {
      put(1, 4 * node(2) - 3 * first - node(1));
      put(2, 2 * (first + node(1)) - 4 * node(2));
    } else {
      put(1, 4 * node(3) - 3 * first - node(1));
      put(2, 4 * node(5) - 3 * first - node(2));
      put(3, 2 * (first + node(1)) - 4 * node(3));
      put(4, 4 * (first - node(3) + node(4) - node(5)));
      put(5, 2 * (first + node(2)) - 4 * node(5));
    }
  }

  /// Of 1, t, t^2 in 2D and 1, b, c, b^2, b c, c^2 in 3D.
  static constexpr std::size_t n_coefficients = Dim == 2 ? 3 : 6;
  std::array<Rows, n_coefficients> a_ = [] {
    std::array<Rows, n_coefficients> a;
    a.fill(Rows::Zero());
    return a;
  }();
};

}  // namespace jampack
