// SPDX-License-Identifier: MIT
#include <jampack/jampack.hpp>

double volume_seen_by_the_other_unit();

int main() {
  return jampack::ball_volume<3>(1) == volume_seen_by_the_other_unit() ? 0 : 1;
}
