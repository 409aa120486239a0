// SPDX-License-Identifier: MIT
#include <jampack/element/macro_simplex.hpp>
#include <jampack/io/checkpoint_compaction.hpp>
#include <jampack/law/signorini.hpp>
#include <jampack/law/signorini_coulomb.hpp>
#include <jampack/mesh/disk_mesh.hpp>

#include "../catch.hpp"
#include "temporary_folder.hpp"

using namespace jampack;
using jampack_tests::contains;
using jampack_tests::TemporaryFolder;

namespace {

using Packing = SoftPacking<2, MacroSimplex<2>, NeoHookean>;

template <class Law>
Compaction<Packing, Law> two_disks(Law law) {
  Packing packing(disk_mesh(64), NeoHookean{1, 0.4, 1},
                  container(Box<2>{Vector<2>(-0.86, -0.86), Vector<2>(0.86, 0.86)}));
  packing.add(1.0, {-0.34, -0.33}, Eigen::Rotation2Dd(0.3).toRotationMatrix());
  packing.add(0.9, {0.335, 0.345}, Eigen::Rotation2Dd(-0.7).toRotationMatrix());
  return Compaction<Packing, Law>(std::move(packing), law, {}, {});
}

template <class Law>
void expect_same_future(Law law) {
  const TemporaryFolder folder;
  auto straight = two_disks(law);
  while (!(straight.step.contacts.pairs.size() > 0 && straight.pressure() > 0)) straight.advance();
  write_checkpoint(folder / "a.jpk", stored_state(straight));
  auto resumed = restored_compaction<Packing>(std::get<StoredState<2>>(read_checkpoint(folder / "a.jpk")),
                                              law, CompactionOptions{}, SoftStepOptions{});
  for (int i = 0; i < 8; ++i) {
    straight.advance();
    resumed.advance();
  }
  CHECK(straight.pressure() > 0);
  CHECK(resumed.pressure() == straight.pressure());
  write_checkpoint(folder / "straight.jpk", stored_state(straight));
  write_checkpoint(folder / "resumed.jpk", stored_state(resumed));
  // One byte string: every number of the state, bit for bit.
  CHECK((read_file(folder / "straight.jpk") == read_file(folder / "resumed.jpk")));
}

}  // namespace

TEST_CASE("a run stopped and resumed is the undisturbed run, bit for bit") {
  SECTION("with friction") {
    expect_same_future(SignoriniCoulomb{0.3});
  }
  SECTION("without") {
    expect_same_future(Signorini{});
  }
}

TEST_CASE("a checkpoint keeps all of a state") {
  const TemporaryFolder folder;
  auto compaction = two_disks(SignoriniCoulomb{0.25});
  for (int i = 0; i < 10; ++i) compaction.advance();
  const auto state = stored_state(compaction, {{"seed", "7"}, {"note", "two\nlines"}});
  write_checkpoint(folder / "a.jpk", state);
  const auto read = std::get<StoredState<2>>(read_checkpoint(folder / "a.jpk"));
  CHECK(read.parameters == state.parameters);
  CHECK(read.element == "macro");
  CHECK(read.material == "neo_hookean");
  CHECK(read.poisson == 0.4);
  CHECK(read.friction == 0.25);
  CHECK(read.room.scale == compaction.packing.room.scale);
  CHECK(read.progress.n_steps == compaction.n_steps);
  CHECK(read.progress.last_duration == compaction.last_duration);
  REQUIRE(read.grains.size() == 2);
  CHECK(read.grains[1].position == compaction.packing.grains[1].position);
  CHECK(read.grains[1].velocity_before == compaction.velocity_before[1]);
  CHECK(read.grains[0].rotation == compaction.packing.grains[0].rotation);
  REQUIRE(read.pairs.size() == compaction.step.contacts.pairs.size());
  REQUIRE(read.walls.size() == compaction.step.contacts.walls.size());
  for (Index c = 0; c < read.pairs.size(); ++c)
    CHECK(read.pairs[c].reaction == compaction.step.contacts.pairs.reaction[c]);
  CHECK(std::filesystem::exists(folder / "a.jpk.part") == false);
}

TEST_CASE("a damaged or foreign checkpoint is refused in one line that names it") {
  const TemporaryFolder folder;
  const auto path = folder / "a.jpk";
  write_checkpoint(path, stored_state(two_disks(Signorini{})));
  const std::string whole = read_file(path);
  const auto reads = [&](const std::string& bytes) {
    write_file(path, bytes);
    try {
      read_checkpoint(path);
    } catch (const InvalidInput& error) {
      CHECK_THAT(error.what(), contains("a.jpk"));
      CHECK(std::string(error.what()).find('\n') == std::string::npos);
      return false;
    }
    return true;
  };
  REQUIRE(reads(whole));
  for (const std::size_t size :
       {std::size_t(0), std::size_t(5), std::size_t(20), std::size_t(40), whole.size() / 2, whole.size() - 1})
    CHECK_FALSE(reads(whole.substr(0, size)));
  CHECK_FALSE(reads(whole + "x"));
  for (const std::size_t at : {std::size_t(0), std::size_t(8), std::size_t(17), std::size_t(30),
                               std::size_t(60), whole.size() / 2, whole.size() - 1}) {
    std::string flipped = whole;
    flipped[at] = static_cast<char>(flipped[at] ^ 0x10);
    CHECK_FALSE(reads(flipped));
  }
  CHECK_THROWS_WITH(read_checkpoint(folder / "none.jpk"), contains("none.jpk"));
}

TEST_CASE("a state is not restored as something else") {
  const auto state = stored_state(two_disks(SignoriniCoulomb{0.3}));
  const auto restore = [&](auto law, double theta) {
    SoftStepOptions options;
    options.theta = theta;
    return restored_compaction<Packing>(state, law, CompactionOptions{}, options);
  };
  CHECK_NOTHROW(restore(SignoriniCoulomb{0.3}, 1));
  CHECK_THROWS_WITH(restore(SignoriniCoulomb{0.2}, 1), contains("friction"));
  CHECK_THROWS_WITH(restore(Signorini{}, 1), contains("friction"));
  CHECK_THROWS_WITH(restore(SignoriniCoulomb{0.3}, 0.5), contains("theta"));
  auto other = state;
  other.element = "linear";
  CHECK_THROWS_WITH(
      restored_compaction<Packing>(other, SignoriniCoulomb{0.3}, CompactionOptions{}, SoftStepOptions{}),
      contains("element linear"));
}
