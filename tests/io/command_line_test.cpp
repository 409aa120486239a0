// SPDX-License-Identifier: MIT
#include <cstdint>
#include <jampack/io/command_line.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "../catch.hpp"

using namespace jampack;
using jampack_tests::contains;

namespace {

struct Values {
  Index grains = 100;
  double friction = 0.3;
  double poisson = 0.495;
  std::uint64_t seed = 1;
  std::string out = "out";
  std::string element = "linear";
  bool list = false;
};

/// Parses as a program would; returns whether it goes on.
bool parse(Values& values, const Array<std::string>& arguments, std::ostream* help = nullptr) {
  CommandLine line("press", "presses grains", arguments);
  line.option("grains", values.grains, at_least(1), "number of grains");
  line.option("friction", values.friction, at_least(0), "friction");
  line.option("poisson", values.poisson, strictly_between(-1, 0.5), "Poisson's ratio");
  line.option("seed", values.seed, at_least(0), "seed");
  line.option("out", values.out, "output folder");
  line.option("element", values.element, {"linear", "macro"}, "element");
  line.flag("list", values.list, "names the elements");
  std::ostringstream nowhere;
  return line.parse(help != nullptr ? *help : nowhere);
}

std::string complaint(const Array<std::string>& arguments) {
  Values values;
  try {
    parse(values, arguments);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("options set their variables and leave the others at their defaults") {
  Values values;
  CHECK(parse(values, {"--grains", "20", "--friction=0", "--seed", "18446744073709551615", "--out", "a b",
                       "--element", "macro", "--list", "--poisson", "-0.5"}));
  CHECK(values.grains == 20);
  CHECK(values.friction == 0);
  CHECK(values.seed == 18446744073709551615ULL);
  CHECK(values.out == "a b");
  CHECK(values.element == "macro");
  CHECK(values.list);
  CHECK(values.poisson == -0.5);

  Values standard;
  CHECK(parse(standard, {}));
  CHECK(standard.grains == 100);
  CHECK(standard.friction == 0.3);
  CHECK_FALSE(standard.list);
}

TEST_CASE("impossible input is refused with a message that names the option") {
  CHECK_THAT(complaint({"--grians", "20"}), contains("unknown option --grians"));
  CHECK_THAT(complaint({"--grains"}), contains("--grains needs a value"));
  CHECK_THAT(complaint({"--grains", "--list"}), contains("--grains needs a value"));
  CHECK_THAT(complaint({"--grains", "0"}), contains("--grains must be at least 1, not 0"));
  CHECK_THAT(complaint({"--grains", "-3"}), contains("--grains must be at least 1, not -3"));
  CHECK_THAT(complaint({"--grains", "2.5"}), contains("--grains must be a whole number, not '2.5'"));
  CHECK_THAT(complaint({"--grains", "20x"}), contains("whole number"));
  CHECK_THAT(complaint({"--grains", ""}), contains("whole number"));
  CHECK_THAT(complaint({"--grains", "99999999999999999999"}), contains("whole number"));
  CHECK_THAT(complaint({"--friction", "nan"}), contains("--friction must be at least 0, not nan"));
  CHECK_THAT(complaint({"--friction", "inf"}), contains("--friction must be at least 0, not inf"));
  CHECK_THAT(complaint({"--friction", "-0.1"}), contains("--friction must be at least 0, not -0.1"));
  CHECK_THAT(complaint({"--friction", "0.3,"}), contains("--friction must be a number"));
  CHECK_THAT(complaint({"--friction", " 0.3"}), contains("--friction must be a number"));
  CHECK_THAT(complaint({"--friction="}), contains("--friction must be a number"));
  CHECK_THAT(complaint({"--poisson", "0.5"}), contains("--poisson must be above -1 and below 0.5, not 0.5"));
  CHECK_THAT(complaint({"--seed", "-1"}), contains("--seed must be a whole number"));
  CHECK_THAT(complaint({"--out", ""}), contains("--out must not be empty"));
  CHECK_THAT(complaint({"--element", "cubic"}),
             contains("--element must be one of linear, macro, not 'cubic'"));
  CHECK_THAT(complaint({"--list=yes"}), contains("--list takes no value"));
  CHECK_THAT(complaint({"--grains", "3", "--grains", "4"}), contains("--grains is given twice"));
  CHECK_THAT(complaint({"stray"}), contains("unexpected argument 'stray'"));
  CHECK_THAT(complaint({"-g", "3"}), contains("unexpected argument '-g'"));
  CHECK(complaint({"--grains", "3"}).empty());
}

TEST_CASE("required arguments come in order and are missed") {
  std::string file, other;
  const auto run = [&](const Array<std::string>& arguments) {
    CommandLine line("audit", "audits", arguments);
    line.argument("CHECKPOINT", file, "a checkpoint");
    line.argument("OTHER", other, "another");
    return line.parse();
  };
  CHECK(run({"a.jpk", "b.jpk"}));
  CHECK(file == "a.jpk");
  CHECK(other == "b.jpk");
  CHECK_THROWS_WITH(run({"a.jpk"}), contains("OTHER is missing"));
  CHECK_THROWS_WITH(run({"a", "b", "c"}), contains("unexpected argument 'c'"));
}

TEST_CASE("--help wins over everything and shows options, ranges and defaults") {
  Values values;
  std::ostringstream help;
  CHECK_FALSE(parse(values, {"--grains", "-3", "--help"}, &help));
  CHECK(values.grains == 100);
  CHECK_THAT(help.str(), contains("--grains N") && contains("at least 1; 100") &&
                             contains("below 0.5; 0.495") && contains("linear, macro; linear") &&
                             contains("--list") && contains("--help"));
}

TEST_CASE("parameters are those in force, and given() tells which were chosen") {
  double friction = 0.3;
  bool fast = false;
  CommandLine line("press", "presses", {"--friction", "0.1"});
  line.option("friction", friction, at_least(0), "friction");
  line.flag("fast", fast, "is fast");
  REQUIRE(line.parse());
  CHECK(line.parameters().text() == "{\n  \"friction\": 0.1,\n  \"fast\": false\n}");
  CHECK(line.given("friction"));
  CHECK_FALSE(line.given("fast"));
  CHECK_THROWS_AS(line.given("speed"), InvalidInput);
}

TEST_CASE("option ranges hold their ends or not") {
  CHECK(from_to(0, 1).contains(0.0));
  CHECK(from_to(0, 1).contains(1.0));
  CHECK_FALSE(from_to_below(0, 1).contains(1.0));
  CHECK(from_to_below(0, 1).contains(0.0));
  CHECK_FALSE(above(0).contains(0.0));
  CHECK_FALSE(strictly_between(0, 1).contains(0.0));
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const OptionRange& range : {any_number(), at_least(0), above(0), from_to(-1, 1)}) {
    CHECK_FALSE(range.contains(nan));
    CHECK_FALSE(range.contains(inf));
    CHECK_FALSE(range.contains(-inf));
  }
  CHECK(any_number().contains(-1e300));
}
