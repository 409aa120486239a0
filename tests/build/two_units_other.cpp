// SPDX-License-Identifier: MIT
#include <jampack/jampack.hpp>

double volume_seen_by_the_other_unit();
double volume_seen_by_the_other_unit() {
  return jampack::ball_volume<3>(1);
}
