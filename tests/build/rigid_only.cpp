// SPDX-License-Identifier: MIT
// A program of rigid balls: it must include no header of meshes, elements or materials.
#include <jampack/geometry/frame.hpp>

int main() { return jampack::contact_frame<2>(jampack::Vector<2>::UnitX()).isUnitary() ? 0 : 1; }
