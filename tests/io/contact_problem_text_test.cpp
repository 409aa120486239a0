// SPDX-License-Identifier: MIT
#include <jampack/io/contact_problem_text.hpp>

#include "../catch.hpp"

using namespace jampack;

TEST_CASE("steps of the natural map that are not positive are refused") {
  const std::string start =
      "jampack-contact-problem 1 unknowns 1 contacts 1 friction 0 free_velocity -1 step ";
  const std::string end = " blocks 1 0 0 2 end";
  const auto file = parse_contact_problem(start + "0.25" + end);
  CHECK(std::get<StoredContactProblem<1>>(file.problem).step == Array<double>{0.25});
  for (const char* step : {"0", "-1", "nan", "inf"})
    CHECK_THROWS_AS(parse_contact_problem(start + step + end), InvalidInput);
}
