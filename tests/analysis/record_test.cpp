// SPDX-License-Identifier: MIT
#include <array>
#include <jampack/analysis/record.hpp>
#include <string_view>

#include "../catch.hpp"

using namespace jampack;

namespace {

struct State {
  double phi = 0.6, pressure = 0.2;
};
struct OtherState {};

struct PackingFraction {
  static constexpr std::array<std::string_view, 1> columns{"phi"};
  std::array<double, 1> operator()(const State& state) const { return {state.phi}; }
};
struct Pressure {
  static constexpr std::array<std::string_view, 2> columns{"P", "P_over_modulus"};
  double modulus;
  std::array<double, 2> operator()(const State& state) const {
    return {state.pressure, state.pressure / modulus};
  }
};
/// Cannot be computed from a State: compiles only as long as nobody names it.
struct NeedsMore {
  static constexpr std::array<std::string_view, 1> columns{"more"};
  template <class S>
  std::array<double, 1> operator()(const S& state) const {
    return {state.not_there};
  }
};
struct WrongCount {
  static constexpr std::array<std::string_view, 2> columns{"a", "b"};
  std::array<double, 1> operator()(const State&) const { return {0}; }
};
struct NoColumns {
  std::array<double, 1> operator()(const State&) const { return {0}; }
};
struct ChangesState {
  static constexpr std::array<std::string_view, 1> columns{"c"};
  std::array<double, 1> operator()(State& state) const { return {state.phi = 0}; }
};

static_assert(Analysis<PackingFraction, State>);
static_assert(Analysis<Pressure, State>);
static_assert(Analysis<Analyses<PackingFraction, Pressure>, State>, "a list is an analysis itself");
static_assert(!Analysis<PackingFraction, OtherState>);
static_assert(!Analysis<WrongCount, State>);
static_assert(!Analysis<NoColumns, State>);
static_assert(!Analysis<ChangesState, State>);

// What is not named, or has no parameters, costs nothing.
static_assert(sizeof(Analyses<PackingFraction>) == 1);
static_assert(sizeof(Analyses<PackingFraction, Pressure>) == sizeof(Pressure));
static_assert(Analyses<>::n_columns == 0);

}  // namespace

TEST_CASE("A record has the columns and values of its analyses, in order") {
  const Analyses record{Pressure{.modulus = 0.4}, PackingFraction{}};
  REQUIRE(record.columns == std::array<std::string_view, 3>{"P", "P_over_modulus", "phi"});
  CHECK(record(State{}) == std::array<double, 3>{0.2, 0.5, 0.6});
  static_assert(decltype(record)::column("P_over_modulus") == 1);
  CHECK(record(State{})[record.column("phi")] == 0.6);
}

TEST_CASE("Records nest, and an empty one is a record") {
  const Analyses inner{PackingFraction{}};
  const Analyses<Analyses<PackingFraction>, Pressure> outer(inner, Pressure{.modulus = 1});
  CHECK(outer.columns == std::array<std::string_view, 3>{"phi", "P", "P_over_modulus"});
  CHECK(outer(State{}) == std::array<double, 3>{0.6, 0.2, 0.2});
  CHECK(Analyses<>()(State{}).empty());
}

TEST_CASE("An analysis that is not named is not instantiated") {
  // NeedsMore would not compile with State; naming it here and not calling the list is still allowed.
  CHECK(Analyses<NeedsMore>::columns[0] == "more");
  CHECK(Analyses<PackingFraction>()(State{})[0] == 0.6);
}
