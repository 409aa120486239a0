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
