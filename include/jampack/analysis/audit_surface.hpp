// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <jampack/analysis/audit_hull.hpp>
#include <limits>
#include <numbers>
#include <optional>

namespace jampack {

/// The curved surface of one grain as the audit sees it: each face a polynomial patch with its own polynomial
/// of averaged nodal normals. Shares nothing with detection/; every search goes over all faces.
template <int Dim>
class AuditSurface {
 public:
  using Nodal = Eigen::Matrix<double, Dim, Eigen::Dynamic>;
  using Coordinates = Eigen::Matrix<double, Dim - 1, 1>;
  static constexpr int n_monomials = Dim == 2 ? 3 : 6;
  using Monomials = Eigen::Matrix<double, n_monomials, 1>;

  /// A point of the surface with its share of the area (length in 2D).
  struct Point {
    Index face;
    Coordinates xi;
    Vector<Dim> position, normal;
    double area;
  };

  /// x = surface point + gap normal, the solution of least |gap|.
  struct Projection {
    Index face = -1;  ///< -1: none within the distance asked for
    Coordinates xi = Coordinates::Zero();
    Vector<Dim> normal = Vector<Dim>::Zero();
    double gap = std::numeric_limits<double>::infinity();
  };

  Array<Point> points;  ///< dense, in the order of the faces
  Vector<Dim> lower, upper;

  AuditSurface(const Mesh<Dim>& mesh, const Nodal& x) : mesh_(&mesh) {
    Nodal normal = Nodal::Zero(Dim, x.cols());
    for (const auto& face : mesh.faces) {
      const auto shape = coefficients(face, x);
      for (Index i = 0; i < face.n_nodes; ++i)
        normal.col(face.node[std::size_t(i)]) += area_vector(shape * slopes(node_coordinates(i)));
    }
    for (Index i = 0; i < normal.cols(); ++i)
      if (const double length = normal.col(i).norm(); length > 0) normal.col(i) /= length;
    lower.setConstant(std::numeric_limits<double>::infinity());
    upper = -lower;
    for (const auto& face : mesh.faces) {
      auto& patch = patches_.emplace_back();
      patch.shape = coefficients(face, x);
      patch.normal = coefficients(face, normal);
      patch.first_point = points.size();
      add_points(patches_.size() - 1, face.n_nodes == Dim ? linear_cuts : quadratic_cuts);
      bound(patch, face, x);
    }
    Array<Vector<Dim>> outward;
    for (const Patch& patch : patches_) outward.push_back(patch.middle_normal);
    hull_.emplace(mesh, x, outward);
  }

  /// Weights of the nodes of a face at xi, in the order of face.node.
  Eigen::Matrix<double, n_monomials, 1> weights(Index face, const Coordinates& xi) const {
    return basis(mesh_->faces[face].n_nodes) * monomials(xi);
  }

  /// Of all S(xi) + gap n(xi) = x on all faces for which use(face) is true, that of least |gap| <= within. A
  /// point farther inside than `within` gets the (negative) distance to the nearest patch centre.
  template <class Use>
  Projection project(const Vector<Dim>& x, double within, Use use) const {
    Projection best;
    Index nearest = -1;
    double nearest_distance = std::numeric_limits<double>::infinity();
    for (Index f = 0; f < patches_.size(); ++f)
      if (const double d = (x - patches_[f].centre).squaredNorm(); use(f) && d < nearest_distance) {
        nearest_distance = d;
        nearest = f;
      }
    if (nearest < 0) return best;
    double limit = within;
    Index closest_point = -1;
    double closest = std::numeric_limits<double>::infinity();
    const auto visit = [&](Index f) {
      const Patch& patch = patches_[f];
      const double reach = limit + patch.radius;
      if ((x - patch.centre).squaredNorm() > reach * reach) return;
      const auto [start, distance] = nearest_point(f, x);
      if (distance < closest) {
        closest = distance;
        closest_point = start;
      }
      Projection p;
      p.face = f;
      p.xi = points[start].xi;
      if (!solve(patch, x, p) || std::abs(p.gap) > limit) return;
      limit = std::abs(p.gap);
      best = p;
    };
    visit(nearest);
    for (Index f = 0; f < patches_.size(); ++f)
      if (f != nearest && use(f)) visit(f);
    if (best.face >= 0) return best;
    // No normal passes through x: beside a crease, or deep inside.
    const Point& point =
        points[closest_point >= 0 ? closest_point
                                  : patches_[nearest].first_point + patches_[nearest].n_points / 2];
    const double side = point.normal.dot(x - point.position);
    if (closest_point < 0 && side < 0 && contains(x)) {
      best = {point.face, point.xi, point.normal, -std::sqrt(nearest_distance)};
    } else if (closest_point >= 0 && closest <= within * within) {
      best = {point.face, point.xi, point.normal, side};
    }
    return best;
  }
  Projection project(const Vector<Dim>& x, double within) const {
    return project(x, within, [](Index) { return true; });
  }

  /// Is x in the bounding box, and in the hull, both widened by `margin`?
  bool may_reach(const Vector<Dim>& x, double margin) const {
    return ((x - lower).array() >= -margin).all() && ((upper - x).array() >= -margin).all() &&
           !hull_->is_beyond(x, margin);
  }

  Vector<Dim> position(Index f, const Coordinates& xi) const { return at(patches_[f], xi); }

  /// Unit normal of a face itself.
  Vector<Dim> own_normal(Index f, const Coordinates& xi) const {
    return area_vector(patches_[f].shape * slopes(xi)).normalized();
  }

  /// Unit normal in the middle of a face.
  const Vector<Dim>& middle_normal(Index f) const { return patches_[f].middle_normal; }

  /// May a face for which use(face) is true come within `distance` of x?
  template <class Use>
  bool has_face_near(const Vector<Dim>& x, double distance, Use use) const {
    for (Index f = 0; f < patches_.size(); ++f) {
      const double reach = distance + patches_[f].radius;
      if ((x - patches_[f].centre).squaredNorm() <= reach * reach && use(f)) return true;
    }
    return false;
  }

  /// Does the surface wind about x?
  bool contains(const Vector<Dim>& x) const { return winding_number(x) > 0.5; }

  /// How often the surface winds about x: 1 inside, 0 outside, 2 where a folded grain overlaps itself.
  double winding_number(const Vector<Dim>& x) const {
    double sum = 0;
    for (const Patch& patch : patches_) {
      const int cuts = patch.cuts;
      if constexpr (Dim == 2) {
        for (int i = 0; i < cuts; ++i) {
          const Vector<2> a = at(patch, Coordinates(double(i) / cuts)) - x;
          const Vector<2> b = at(patch, Coordinates(double(i + 1) / cuts)) - x;
          sum += std::atan2(a[0] * b[1] - a[1] * b[0], a.dot(b)) / (2 * std::numbers::pi);
        }
      } else {
        const auto corner = [&](int i, int j) -> Vector<3> {
          return at(patch, Coordinates(double(i) / cuts, double(j) / cuts)) - x;
        };
        for (int i = 0; i < cuts; ++i)
          for (int j = 0; i + j < cuts; ++j) {
            sum += solid_angle(corner(i, j), corner(i + 1, j), corner(i, j + 1));
            if (i + j + 1 < cuts)
              sum += solid_angle(corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
          }
      }
    }
    return sum;
  }

  /// Enclosed volume (area in 2D): (1/Dim) int x . n dA by Gauss's rule, collapsed onto the triangle in 3D.
  double volume() const {
    constexpr std::array<double, 4> node = {-0.8611363115940526, -0.3399810435848563, 0.3399810435848563,
                                            0.8611363115940526};
    constexpr std::array<double, 4> weight = {0.3478548451374538, 0.6521451548625461, 0.6521451548625461,
                                              0.3478548451374538};
    const Vector<Dim> origin = 0.5 * (lower + upper);
    double sum = 0;
    for (const Patch& patch : patches_)
      for (std::size_t i = 0; i < 4; ++i) {
        const double s = 0.5 * (1 + node[i]);
        const auto add = [&](const Coordinates& xi, double w) {
          sum += w / Dim * area_vector(patch.shape * slopes(xi)).dot(at(patch, xi) - origin);
        };
        if constexpr (Dim == 2) {
          add(Coordinates(s), weight[i] / 2);
        } else {
          for (std::size_t j = 0; j < 4; ++j)
            add({s, (1 - s) * 0.5 * (1 + node[j])}, weight[i] / 2 * weight[j] / 2 * (1 - s));
        }
      }
    return sum;
  }

  /// Do two faces have a node in common?
  bool are_adjacent(Index f, Index g) const {
    const auto &a = mesh_->faces[f], &b = mesh_->faces[g];
    for (Index i = 0; i < a.n_nodes; ++i)
      for (Index j = 0; j < b.n_nodes; ++j)
        if (a.node[std::size_t(i)] == b.node[std::size_t(j)]) return true;
    return false;
  }

 private:
  static constexpr int quadratic_cuts = Dim == 2 ? 9 : 5, linear_cuts = Dim == 2 ? 5 : 3;
  using Coefficients = Eigen::Matrix<double, Dim, n_monomials>;
  struct Patch {
    Coefficients shape, normal;
    Vector<Dim> centre;  ///< of a ball that holds the face
    Vector<Dim> middle_normal;
    double radius = 0;
    Index first_point = 0, n_points = 0;
    int cuts = 1;
  };

  static Monomials monomials(const Coordinates& xi) {
    if constexpr (Dim == 2)
      return {1, xi[0], xi[0] * xi[0]};
    else
      return Monomials{{1}, {xi[0]}, {xi[1]}, {xi[0] * xi[0]}, {xi[0] * xi[1]}, {xi[1] * xi[1]}};
  }
  static Eigen::Matrix<double, n_monomials, Dim - 1> slopes(const Coordinates& xi) {
    Eigen::Matrix<double, n_monomials, Dim - 1> d;
    if constexpr (Dim == 2)
      d << 0, 1, 2 * xi[0];
    else
      d << 0, 0, 1, 0, 0, 1, 2 * xi[0], 0, xi[1], xi[0], 0, 2 * xi[1];
    return d;
  }
  static Coordinates node_coordinates(Index i) {
    if constexpr (Dim == 2)
      return Coordinates(i == 2 ? 0.5 : double(i));
    else
      return Coordinates(i == 1 ? 1 : i == 3 || i == 4 ? 0.5 : 0, i == 2 ? 1 : i == 4 || i == 5 ? 0.5 : 0);
  }
  /// Rows: the polynomials that are 1 at one node and 0 at the others, found by inversion.
  static Eigen::Matrix<double, n_monomials, n_monomials> basis(Index n_nodes) {
    const auto make = [](Index n) {
      Eigen::Matrix<double, n_monomials, n_monomials> result;
      result.setZero();
      Eigen::MatrixXd values(n, n);
      for (Index i = 0; i < n; ++i) values.col(i) = monomials(node_coordinates(i)).head(n);
      result.topLeftCorner(n, n) = values.inverse();
      return result;
    };
    static const auto linear = make(Dim), quadratic = make(n_monomials);
    return n_nodes == Dim ? linear : quadratic;
  }
  static Coefficients coefficients(const BoundaryFace<Dim>& face, const Nodal& field) {
    Coefficients nodal = Coefficients::Zero();
    for (Index i = 0; i < face.n_nodes; ++i) nodal.col(i) = field.col(face.node[std::size_t(i)]);
    return nodal * basis(face.n_nodes);
  }
  static Vector<Dim> area_vector(const Eigen::Matrix<double, Dim, Dim - 1>& tangents) {
    if constexpr (Dim == 2)
      return {tangents(1, 0), -tangents(0, 0)};
    else
      return tangents.col(0).cross(tangents.col(1));
  }
  static Vector<Dim> at(const Patch& patch, const Coordinates& xi) { return patch.shape * monomials(xi); }
  static double solid_angle(const Vector<3>& a, const Vector<3>& b, const Vector<3>& c) {
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    const double below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    return 2 * std::atan2(a.dot(b.cross(c)), below) / (4 * std::numbers::pi);
  }

  /// Centres of the equal parts a face is cut into.
  void add_points(Index f, int cuts) {
    Patch& patch = patches_[f];
    patch.cuts = cuts;
    const auto add = [&](const Coordinates& xi) {
      const double share = 1.0 / (Dim == 2 ? cuts : 2 * cuts * cuts);
      points.push_back({f, xi, at(patch, xi), (patch.normal * monomials(xi)).normalized(),
                        share * area_vector(patch.shape * slopes(xi)).norm()});
      ++patch.n_points;
    };
    for (int i = 0; i < cuts; ++i) {
      if constexpr (Dim == 2) {
        add(Coordinates((i + 0.5) / cuts));
      } else {
        for (int j = 0; i + j < cuts; ++j) {
          add(Coordinates((i + 1.0 / 3) / cuts, (j + 1.0 / 3) / cuts));
          if (i + j + 1 < cuts) add(Coordinates((i + 2.0 / 3) / cuts, (j + 2.0 / 3) / cuts));
        }
      }
    }
  }

  void bound(Patch& patch, const BoundaryFace<Dim>& face, const Nodal& x) {
    patch.centre = at(patch, Coordinates::Constant(1.0 / Dim));
    patch.middle_normal = (patch.normal * monomials(Coordinates::Constant(1.0 / Dim))).normalized();
    const auto include = [&](const Vector<Dim>& p) {
      patch.radius = std::max(patch.radius, (p - patch.centre).norm());
      lower = lower.cwiseMin(p);
      upper = upper.cwiseMax(p);
    };
    for (Index i = 0; i < face.n_nodes; ++i) include(x.col(face.node[std::size_t(i)]));
    for (Index k = 0; k < patch.n_points; ++k) include(points[patch.first_point + k].position);
    patch.radius *= 1.1;
  }

  std::pair<Index, double> nearest_point(Index f, const Vector<Dim>& x) const {
    std::pair<Index, double> best{-1, std::numeric_limits<double>::infinity()};
    const Patch& patch = patches_[f];
    for (Index k = patch.first_point; k < patch.first_point + patch.n_points; ++k)
      if (const double d = (points[k].position - x).squaredNorm(); d < best.second) best = {k, d};
    return best;
  }

  /// Newton on S(xi) + c m(xi) = x with m the normals as interpolated, not normalised; false where it does
  /// not end inside the face.
  static bool solve(const Patch& patch, const Vector<Dim>& x, Projection& p) {
    Vector<Dim> m = patch.normal * monomials(p.xi);
    double c = m.dot(x - at(patch, p.xi)) / m.squaredNorm();
    bool converged = false;
    for (int iteration = 0; iteration < 20; ++iteration) {
      const Monomials value = monomials(p.xi);
      m = patch.normal * value;
      const Vector<Dim> error = x - patch.shape * value - c * m;
      if (converged && error.norm() <= 1e-12 * patch.radius) break;
      Matrix<Dim> jacobian;
      jacobian.template leftCols<Dim - 1>() = (patch.shape + c * patch.normal) * slopes(p.xi);
      jacobian.col(Dim - 1) = m;
      Vector<Dim> step = jacobian.inverse() * error;
      const double largest = step.template head<Dim - 1>().cwiseAbs().maxCoeff();
      if (!(largest < 1e3)) return false;
      if (largest > 0.3) step *= 0.3 / largest;
      p.xi += step.template head<Dim - 1>();
      c += step[Dim - 1];
      if ((p.xi.array() < -0.3).any() || p.xi.sum() > 1.3) return false;
      converged = largest < 1e-9;
    }
    constexpr double slack = 1e-9;
    if (!converged || p.xi.minCoeff() < -slack || p.xi.sum() > 1 + slack) return false;
    const double length = m.norm();
    p.normal = m / length;
    p.gap = c * length;
    return true;
  }

  const Mesh<Dim>* mesh_;
  Array<Patch> patches_;
  std::optional<AuditHull<Dim>> hull_;
};

}  // namespace jampack
