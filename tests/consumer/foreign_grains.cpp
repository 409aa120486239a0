// SPDX-License-Identifier: MIT
// A researcher's own element and material, each in one file, in the grains of the library, together and each
// with the library's own of the other kind. Returns how many checks fail.
#include <cmath>
#include <cstdio>
#include <jampack/body/grain.hpp>
#include <jampack/element/macro_simplex.hpp>
#include <jampack/material/hencky.hpp>
#include <jampack/mesh/ball_mesh.hpp>

#include "plain_tetrahedron.hpp"
#include "stiffening_solid.hpp"

using namespace jampack;

static_assert(Element<PlainTetrahedron, 3, StiffeningSolid> && Element<PlainTetrahedron, 3, Hencky>);
static_assert(!Element<PlainTetrahedron, 3, double> && !Element<PlainTetrahedron, 2, StiffeningSolid>);

namespace {

/// 0 if the forces and the tangent of a deformed grain are derivatives of its energy, else 1.
template <class E, class M>
int check(const char* what, const M& material) {
  material.validate();
  const GrainModel<3, E, M> model(ball_mesh(100), material);
  const Grain<GrainModel<3, E, M>> grain(model, 2.0, Vector<3>(1, 2, 3), Matrix<3>::Identity());
  auto x = grain.position;
  for (Index i = 0; i < x.size(); ++i) x.data()[i] += 0.02 * std::sin(static_cast<double>(i * i));
  typename Grain<GrainModel<3, E, M>>::Nodal force, forward, backward, step(3, x.cols());
  BlockMatrix<3> tangent;
  if (!grain.internal_force_and_tangent(model, x, force, tangent)) return 1;
  for (Index i = 0; i < step.size(); ++i) step.data()[i] = 1e-6 * std::cos(static_cast<double>(i));
  const auto energy = [&](const auto& at) {
    double sum = 0;
    for (const auto& cell : grain.cells) sum += E::energy(cell, material, grain.gather(cell, at));
    return sum;
  };
  grain.internal_force(model, x + step, forward);
  grain.internal_force(model, x - step, backward);
  Eigen::VectorXd product = Eigen::VectorXd::Zero(x.size());
  tangent.add_product(model.pattern, step.data(), product.data());
  const double work = force.cwiseProduct(step).sum(), gained = (energy(x + step) - energy(x - step)) / 2;
  const double force_error = std::abs(work - gained) / std::abs(work);
  const double tangent_error = (2 * product - (forward - backward).reshaped()).norm() / (2 * product.norm());
  std::printf("%s: force off by %.1e, tangent by %.1e\n", what, force_error, tangent_error);
  return force_error < 1e-7 && tangent_error < 1e-7 ? 0 : 1;
}

}  // namespace

int check_foreign_grains() {
  return check<PlainTetrahedron>("own element, own material", StiffeningSolid{}) +
         check<PlainTetrahedron>("own element", Hencky{}) +
         check<MacroSimplex<3>>("own material", StiffeningSolid{});
}
