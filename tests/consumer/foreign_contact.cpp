// SPDX-License-Identifier: MIT
// A researcher's own contact discretisation, in one file, in the steps of the library. Returns how many
// checks fail.
#include <cmath>
#include <cstdio>
#include <jampack/element/macro_simplex.hpp>
#include <jampack/law/signorini_coulomb.hpp>
#include <jampack/material/neo_hookean.hpp>
#include <jampack/mesh/ball_mesh.hpp>
#include <jampack/stepping/soft_step.hpp>

#include "face_centres.hpp"

using namespace jampack;

/// 0 if two balls pressed in a box meet, and push the walls above and below equally, else 1.
int check_foreign_contact() {
  using Packing = SoftPacking<3, MacroSimplex<3>, NeoHookean>;
  const Vector<3> corner(0.5, 0.5, 1);
  Packing packing(ball_mesh(200), NeoHookean{.young = 1, .poisson = 0.3}, container(Box<3>{-corner, corner}));
  packing.add(1.0, {0, 0, -0.5});
  packing.add(1.0, {0, 0, 0.5});
  SoftStep<Packing, SignoriniCoulomb, ProximalNewton, FaceCentres> step(SignoriniCoulomb{0.3}, {});
  bool converged = false;  // where one step fails, the next makes up for it
  for (const double scale : {0.99, 0.98, 0.97, 0.96, 0.95, 0.94, 0.94}) {
    converged = step.advance(packing, 100, scale, FirstGuess::rest).converged;
    for (auto& grain : packing.grains) grain.velocity.setZero();
  }
  Vector<3> on_walls = Vector<3>::Zero();
  double up = 0, between = 0;
  for (Index c = 0; c < step.contacts.walls.size(); ++c) {
    const Vector<3> force = step.contacts.walls.force(c);
    on_walls += force;
    up += std::max(force[2], 0.0);
  }
  for (Index c = 0; c < step.contacts.pairs.size(); ++c) between += std::abs(step.contacts.pairs.force(c)[2]);
  std::printf("own contact: force %.3e, between the grains %.3e, out of balance %.1e\n", up, between,
              on_walls.norm());
  return converged && up > 1e-4 && std::abs(between / up - 1) < 1e-3 && on_walls.norm() < 1e-3 * up ? 0 : 1;
}
