// SPDX-License-Identifier: MIT
// A program of rigid disks: it must include no header of meshes, elements or materials, and instantiate
// nothing three-dimensional.
#include <jampack/law/signorini_coulomb.hpp>
#include <jampack/packing/random_packing.hpp>
#include <jampack/stepping/jam.hpp>

int main() {
  using namespace jampack;
  const auto loose = random_packing<2>({.n_grains = 8});
  const auto jammed = jam(loose, SignoriniCoulomb{.friction = 0.3});
  return jammed.packing_fraction > loose.packing_fraction() ? 0 : 1;
}
