// SPDX-License-Identifier: MIT
#include <jampack/analysis/audit_surface.hpp>
#include <jampack/detection/grain_surface.hpp>
#include <jampack/mesh/ball_mesh.hpp>
#include <jampack/mesh/disk_mesh.hpp>

#include "../catch.hpp"

using namespace jampack;
using Catch::Matchers::WithinAbs;

namespace {

template <int Dim>
Mesh<Dim> grain_mesh() {
  if constexpr (Dim == 2)
    return disk_mesh(100);
  else
    return ball_mesh(400);
}

/// A ball pressed nearly into a cube: flat sides, and ridges that a mesh of this size only just resolves.
template <int Dim>
typename GrainSurface<Dim>::Nodal pressed_ball(const Mesh<Dim>& mesh) {
  typename GrainSurface<Dim>::Nodal x(Dim, mesh.nodes.size());
  Matrix<Dim> turn = Matrix<Dim>::Random();
  turn = turn.householderQr().householderQ();
  for (Index i = 0; i < mesh.nodes.size(); ++i) {
    const Vector<Dim> p = turn * mesh.nodes[i];
    const double side = p.template lpNorm<Eigen::Infinity>();
    x.col(i) = std::pow(p.norm() / std::max(side, 1e-12), 0.6) * p;
  }
  return x;
}

}  // namespace

TEMPLATE_TEST_CASE_SIG("Beside a ridge a walk ends where brute force finds the least distance", "",
                       ((int Dim), Dim), 2, 3) {
  std::srand(3);
  const auto mesh = grain_mesh<Dim>();
  const auto boundary = make_boundary(mesh);
  Index n_points = 0, n_beside = 0;
  for (int shape = 0; shape < 4; ++shape) {
    const auto x = pressed_ball<Dim>(mesh);
    const AuditSurface<Dim> oracle(mesh, x);
    GrainSurface<Dim> surface;
    surface.update(boundary, x, 1.0);
    for (const auto& point : oracle.points)
      for (const double height : {-1e-3, 1e-3, 1e-2}) {
        const Vector<Dim> p = point.position + height * point.normal;
        const auto expected = oracle.project(p, 0.2);
        for (const Index start : boundary.neighbour[point.face]) {
          const auto found = surface.project(p, start);
          ++n_points;
          if (!found.on_surface || std::abs(found.gap - expected.gap) > 1e-9) ++n_beside;
        }
      }
  }
  INFO(n_beside << " of " << n_points);
  CHECK(n_points > 1000);
  CHECK(n_beside == 0);
}
