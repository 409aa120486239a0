// SPDX-License-Identifier: MIT
#include <jampack/detection/weighted_contact.hpp>

#include "../catch.hpp"
#include "pressed_blocks.hpp"

using namespace jampack;
using namespace jampack_tests;

// About twenty nodes of one side lie in the contact, up to 0.12 of its half-width apart where slip begins.
TEMPLATE_TEST_CASE("Cattaneo and Mindlin: stick width, tractions and hysteresis loop in plane strain", "",
                   SampledContact, WeightedContact) {
  const auto figures = measure_slip<QuadraticSimplex<2>, TestType>(12, 4, 0.0035, 5, {0.25, 0.5, 0.75}, 4);
  INFO("half-width " << figures.half_width_error << ", pressure " << figures.pressure_error << ", traction "
                     << figures.traction_error << ", stick " << figures.stick_error << " of nodes "
                     << figures.spacing << " apart, loop " << figures.loop_error << ", closing "
                     << figures.closing_error);
  CHECK(std::abs(figures.half_width_error) < figures.spacing);
  CHECK(figures.pressure_error < 0.015);
  CHECK(figures.traction_error < 0.02);
  CHECK(figures.stick_error < figures.spacing);
  CHECK(std::abs(figures.loop_error) < 0.04);
  CHECK(std::abs(figures.closing_error) < 0.005);
}
