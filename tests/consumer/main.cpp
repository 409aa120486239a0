// SPDX-License-Identifier: MIT
#include <jampack/jampack.hpp>

int main() {
  const jampack::Frame<3> frame = jampack::contact_frame<3>(jampack::Vector<3>::UnitZ());
  return frame.isUnitary() ? 0 : 1;
}
