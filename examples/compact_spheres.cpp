// SPDX-License-Identifier: MIT
// Spheres: random packing -> jammed -> meshed -> compacted by closing walls. See --help.
#include <jampack/mesh/ball_mesh.hpp>

#include "compaction_program.hpp"

int main(int argc, char** argv) {
  using namespace jampack;
  return run_program(argc, argv, "presses soft spheres from loose to dense", [](CommandLine& line) {
    return compaction_program<3>(line, [](Index cells) { return ball_mesh(cells); });
  });
}
