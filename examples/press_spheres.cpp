// SPDX-License-Identifier: MIT
// Twenty soft frictional spheres, pressed from loose to a packing fraction of 0.9.
#include <cstdio>
#include <jampack/element/macro_simplex.hpp>
#include <jampack/law/signorini_coulomb.hpp>
#include <jampack/material/neo_hookean.hpp>
#include <jampack/mesh/ball_mesh.hpp>
#include <jampack/packing/handover.hpp>
#include <jampack/stepping/jam.hpp>
#include <jampack/stepping/press_to.hpp>

int main() {
  using namespace jampack;
  const NeoHookean rubber{.young = 1, .poisson = 0.495};
  const SignoriniCoulomb contact{.friction = 0.3};
  const double stress = 1e-5;

  const auto loose = random_packing<3>({.n_grains = 20, .seed = 1});
  const auto jammed = jam(loose, contact, {.stress = stress});

  Compaction press(meshed_grains<MacroSimplex>(jammed.packing, ball_mesh(400), rubber), contact);
  press_to(press, {.stress = stress});
  while (press.packing_fraction() < 0.9) {
    press.advance();
    std::printf("phi %.4f  P/E %.3e\n", press.packing_fraction(), press.pressure());
  }
}
