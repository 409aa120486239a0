// SPDX-License-Identifier: MIT
#ifdef INCLUDE_EVERYTHING  // what is installed is complete; elsewhere one header shows that it is found
#include <jampack/jampack.hpp>
int check_foreign_grains();
int check_foreign_contact();
#else
#include <jampack/geometry/frame.hpp>
#endif

int main() {
  const jampack::Frame<3> frame = jampack::contact_frame<3>(jampack::Vector<3>::UnitZ());
  int n_failures = frame.isUnitary() ? 0 : 1;
#ifdef INCLUDE_EVERYTHING
  n_failures += check_foreign_grains() + check_foreign_contact();
#endif
  return n_failures;
}
