// SPDX-License-Identifier: MIT
#include <jampack/io/run_program.hpp>
#include <sstream>
#include <stdexcept>

#include "../catch.hpp"

using namespace jampack;

TEST_CASE("how a program ends becomes its exit code and one line") {
  const char* const argv[] = {"/some/where/press", "--grains", "20"};
  std::ostringstream errors;
  const auto run = [&](auto body) { return run_program(3, argv, "presses", body, errors); };

  CHECK(run([](CommandLine&) {}) == 0);
  CHECK(run([](CommandLine&) { return 1; }) == 1);
  CHECK(errors.str().empty());

  CHECK(run([](CommandLine& line) { return line.parse() ? 0 : 0; }) == 2);
  CHECK(errors.str() == "press: unknown option --grains; see --help\n");

  errors.str("");
  CHECK(run([](CommandLine&) { throw NotConverged("step 3 failed\nfor good"); }) == 1);
  CHECK(errors.str() == "press: step 3 failed for good\n");

  errors.str("");
  CHECK(run([](CommandLine&) { throw std::runtime_error("disk full"); }) == 1);
  CHECK(errors.str() == "press: disk full\n");

  errors.str("");
  CHECK(run([](CommandLine&) { throw std::bad_alloc(); }) == 1);
  CHECK(errors.str() == "press: out of memory\n");
}

TEST_CASE("a program sees its own arguments") {
  const char* const argv[] = {"press", "--grains", "20"};
  Index grains = 1;
  const int code = run_program(3, argv, "presses", [&](CommandLine& line) {
    line.option("grains", grains, at_least(1), "grains");
    if (!line.parse()) return;
  });
  CHECK(code == 0);
  CHECK(grains == 20);
}
