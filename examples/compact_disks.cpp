// SPDX-License-Identifier: MIT
// Disks: random packing -> jammed -> meshed -> compacted by closing walls. See --help.
#include <jampack/mesh/disk_mesh.hpp>

#include "compaction_program.hpp"

int main(int argc, char** argv) {
  using namespace jampack;
  return run_program(argc, argv, "presses soft disks from loose to dense", [](CommandLine& line) {
    return compaction_program<2>(line, [](Index cells) { return disk_mesh(cells); });
  });
}
