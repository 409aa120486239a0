// SPDX-License-Identifier: MIT
#include <cstdio>
#include <jampack/io/progress.hpp>
#include <string>

#include "../catch.hpp"

using jampack::Progress;
using jampack_tests::contains;

namespace {

std::string content(std::FILE* stream) {
  std::fflush(stream);
  std::rewind(stream);
  std::string text;
  for (int character = std::fgetc(stream); character != EOF; character = std::fgetc(stream))
    text += static_cast<char>(character);
  std::fclose(stream);
  return text;
}

}  // namespace

TEST_CASE("away from a terminal progress is plain lines, the first and the last whatever the rate") {
  std::FILE* stream = std::tmpfile();
  REQUIRE(stream != nullptr);
  {
    Progress progress(stream, 3600);
    progress.phase("compaction", 1);
    for (int i = 0; i <= 100; ++i) progress.show(0.01 * i, {{"phi", 0.01 * i}, {"sweeps", 3}});
    progress.phase("relaxation", 1);
    progress.show(0.0, {{"phi", 0.0}});
  }
  CHECK(content(stream) ==
        "compaction  phi 0  sweeps 3\ncompaction  phi 1  sweeps 3  left 0 s\nrelaxation  phi 0\n");
}

TEST_CASE("without a pause between lines every state is shown") {
  std::FILE* stream = std::tmpfile();
  REQUIRE(stream != nullptr);
  {
    Progress progress(stream, 0);
    progress.phase("p", 1);
    for (int i = 0; i < 3; ++i) progress.show(0.0, {});
  }
  CHECK(content(stream) == "p\np\np\n");
}
