// SPDX-License-Identifier: MIT
#include <jampack/analysis/audit_surface.hpp>
#include <jampack/detection/grain_surface.hpp>
#include <jampack/mesh/ball_mesh.hpp>
#include <jampack/mesh/disk_mesh.hpp>
#include <jampack/packing/random.hpp>

#include "../catch.hpp"

using namespace jampack;

namespace {

template <int Dim>
Mesh<Dim> grain_mesh() {
  if constexpr (Dim == 2)
    return disk_mesh(100);
  else
    return ball_mesh(400);
}

/// A ball pressed nearly into a cube, `flat` in [0, 1]: flat sides, and ridges that a mesh of this size only
/// just resolves.
template <int Dim>
typename GrainSurface<Dim>::Nodal pressed_ball(const Mesh<Dim>& mesh, double flat, RandomSource& random) {
  typename GrainSurface<Dim>::Nodal x(Dim, mesh.nodes.size());
  const Matrix<Dim> turn = rotation_matrix<Dim>(random.orientation<Dim>());
  for (Index i = 0; i < mesh.nodes.size(); ++i) {
    const Vector<Dim> p = turn * mesh.nodes[i];
    const double side = p.template lpNorm<Eigen::Infinity>();
    x.col(i) = std::pow(p.norm() / std::max(side, 1e-12), flat) * p;
  }
  return x;
}

}  // namespace

TEMPLATE_TEST_CASE_SIG("Beside a ridge the projection found is that of brute force", "", ((int Dim), Dim), 2,
                       3) {
  RandomSource random(3);
  const auto mesh = grain_mesh<Dim>();
  const auto boundary = make_boundary(mesh);
  Index n_points = 0, n_beside = 0, n_far = 0, n_wrong_side = 0;
  for (const double flat : {0.5, 0.6, 0.7, 0.8}) {
    const auto x = pressed_ball<Dim>(mesh, flat, random);
    const AuditSurface<Dim> oracle(mesh, x);
    GrainSurface<Dim> surface;
    surface.update(boundary, x, 1.0);
    for (const auto& point : oracle.points) {
      for (const double height : {-1e-3, 1e-3, 1e-2}) {
        const Vector<Dim> p = point.position + height * point.normal;
        const auto expected = oracle.project(p, 0.2);
        const auto found = surface.project(p);
        ++n_points;
        if (!found.on_surface || std::abs(found.gap - expected.gap) > 1e-9) ++n_beside;
      }
      // Farther away there are solutions of (3) that pass through the ridge.
      const double height = random.uniform(-0.04, 0.04);
      if (std::abs(height) < 5e-3) continue;
      const Vector<Dim> p = point.position + height * point.normal;
      const bool inside = oracle.contains(p);
      const auto found = surface.project(p);
      ++n_far;
      if (surface.contains(p) != inside || (found.on_surface && (found.gap < 0) != inside)) ++n_wrong_side;
    }
  }
  INFO(n_beside << " of " << n_points << " not as expected, " << n_wrong_side << " of " << n_far
                << " on the wrong side");
  CHECK(n_points > 1000);
  CHECK(n_beside == 0);
  CHECK(n_far > 300);
  CHECK(n_wrong_side == 0);
}

TEMPLATE_TEST_CASE_SIG("What is called a projection is one: x = S + g n", "", ((int Dim), Dim), 2, 3) {
  RandomSource random(5);
  const auto mesh = grain_mesh<Dim>();
  const auto boundary = make_boundary(mesh);
  Index n_found = 0;
  double error = 0;
  for (const double flat : {0.7, 0.9, 1.0}) {
    const auto x = pressed_ball<Dim>(mesh, flat, random);
    GrainSurface<Dim> surface;
    surface.update(boundary, x, 1.0);
    for (int k = 0; k < 4000; ++k) {
      const Index i = boundary.nodes[Index(random.uniform(0, double(boundary.nodes.size()) - 1e-9))];
      Vector<Dim> p = x.col(i);
      for (int a = 0; a < Dim; ++a) p[a] += random.uniform(-0.1, 0.1);
      const auto found = surface.project(p);
      if (!found.on_surface) continue;
      ++n_found;
      error = std::max(error, (surface.point(found.face, found.xi) + found.gap * found.normal - p).norm());
    }
  }
  CHECK(n_found > 6000);
  CHECK(error < 2e-6);
}

TEMPLATE_TEST_CASE_SIG("Tangent planes are two at a hollow crease, and cut nothing of the surface away", "",
                       ((int Dim), Dim), 2, 3) {
  RandomSource random(7);
  const auto mesh = grain_mesh<Dim>();
  const auto boundary = make_boundary(mesh);
  const auto x = pressed_ball<Dim>(mesh, 0, random);
  const auto planes_at = [&](const GrainSurface<Dim>& surface, const Vector<Dim>& p) {
    return surface.tangent_planes(p, surface.project(p), 0.02);
  };
  // A corner pushed in makes hollow creases about it, one pulled out makes ridges.
  for (const double dent : {-0.06, 0.06}) {
    auto shape = x;
    const Index corner = boundary.faces[0].node[0];
    shape.col(corner) *= 1 + dent;
    GrainSurface<Dim> surface;
    surface.update(boundary, shape, 1.0);
    Index n_two = 0, n_beside = 0;
    double cut = 0, lean = 0;
    for (Index f = 0; f < boundary.faces.size(); ++f)
      for (const auto& xi : face_samples<Dim>(12)) {
        const Vector<Dim> p = surface.point(f, xi);
        const auto planes = planes_at(surface, p);
        REQUIRE(!planes.empty());
        const auto& first = planes[0];
        n_two += planes.size() > 1;
        n_beside += (surface.point(first.face, first.xi) - p).norm() > 1e-9;
        for (const auto& plane : planes) {
          cut = std::max(cut, -plane.normal.dot(p - surface.point(plane.face, plane.xi)));
          lean = std::max(lean, (plane.normal - surface.own_normal(plane.face, plane.xi)).norm());
        }
      }
    INFO("dent " << dent);
    CHECK(n_beside == 0);
    CHECK(cut < 1e-9);
    CHECK(lean < 1e-12);
    // On the corner itself, only the dented one is in a hollow.
    const Vector<Dim> beside = Vector<Dim>(shape.col(corner)) + 1e-3 * Vector<Dim>::Ones().normalized();
    if (dent < 0) CHECK(planes_at(surface, beside).size() > 1);
    if (dent > 0 && Dim == 2) CHECK(planes_at(surface, beside).size() == 1);
    if (dent < 0) CHECK(n_two > 0);
    if (dent > 0 && Dim == 2) CHECK(n_two == 0);
  }
  GrainSurface<Dim> smooth;
  smooth.update(boundary, x, 1.0);
  for (Index f = 0; f < boundary.faces.size(); ++f)
    CHECK(planes_at(smooth, smooth.point(f, FaceCoordinates<Dim>::Constant(1.0 / Dim))).size() == 1);
}
