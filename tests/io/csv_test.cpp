// SPDX-License-Identifier: MIT
#include <cmath>
#include <jampack/io/csv_table.hpp>
#include <jampack/io/csv_writer.hpp>
#include <limits>

#include "../catch.hpp"
#include "temporary_folder.hpp"

using namespace jampack;
using jampack_tests::contains;
using jampack_tests::TemporaryFolder;

namespace {
const Array<std::string> columns{"phi", "pressure"};
const double no_value = std::numeric_limits<double>::quiet_NaN();
}  // namespace

TEST_CASE("CSV rows are on disk as soon as written and read back exactly") {
  const TemporaryFolder folder;
  CsvWriter csv(folder / "curve.csv", columns);
  csv.write({1.0 / 3.0, no_value});
  CHECK(read_file(folder / "curve.csv") == "phi,pressure\n0.3333333333333333,\n");
  csv.write(Array<double>{0.5, 1e-17});
  const CsvTable table = read_csv(folder / "curve.csv");
  REQUIRE(table.n_rows() == 2);
  CHECK(table.column("phi")[0] == 1.0 / 3.0);
  CHECK(std::isnan(table.column("pressure")[0]));
  CHECK(table.column("pressure")[1] == 1e-17);
  CHECK_THROWS_WITH(table.column("z"), contains("no column 'z'"));
}

TEST_CASE("CSV texts are quoted where they must be") {
  const TemporaryFolder folder;
  CsvWriter csv(folder / "a.csv", {"compiler", "flags", "n"});
  csv.write({"GCC", "-O3, \"fast\"", Index(3)});
  CHECK(read_file(folder / "a.csv") == "compiler,flags,n\nGCC,\"-O3, \"\"fast\"\"\",3\n");
}

TEST_CASE("a row of the wrong length is refused and nothing written") {
  const TemporaryFolder folder;
  CsvWriter csv(folder / "a.csv", columns);
  CHECK_THROWS_AS(csv.write({1.0}), InvalidInput);
  CHECK(read_file(folder / "a.csv") == "phi,pressure\n");
}

TEST_CASE("a resumed CSV is cut back and goes on as if undisturbed") {
  const TemporaryFolder folder;
  const auto path = folder / "curve.csv";
  {
    CsvWriter csv(path, columns);
    for (int row = 0; row < 5; ++row) csv.write({0.1 * row, row});
  }
  const std::string undisturbed = read_file(path);
  write_file(path, undisturbed + "0.6,7");  // killed while it wrote a row
  {
    CsvWriter csv = CsvWriter::resume(path, columns, 3);
    CHECK(read_csv(path).n_rows() == 3);
    for (int row = 3; row < 5; ++row) csv.write({0.1 * row, row});
  }
  CHECK(read_file(path) == undisturbed);

  CHECK_THROWS_WITH(CsvWriter::resume(path, columns, 6), contains("only 5 of the 6 rows"));
  CHECK_THROWS_WITH(CsvWriter::resume(path, {"phi", "z"}, 2), contains("other columns"));
  CHECK_THROWS_WITH(CsvWriter::resume(folder / "none.csv", columns, 0), contains("no such file"));
  CHECK(read_file(path) == undisturbed);
}

TEST_CASE("malformed CSV files are refused with the line") {
  const TemporaryFolder folder;
  const auto complaint = [&](const std::string& content) {
    write_file(folder / "bad.csv", content);
    try {
      read_csv(folder / "bad.csv");
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK_THAT(complaint("a,b\n1,2\n1\n"), contains("line 3: 1 cells for 2 columns"));
  CHECK_THAT(complaint("a,b\n1,x\n"), contains("line 2: 'x' is not a number"));
  CHECK_THAT(complaint("a,b\n1,2"), contains("cut short"));
  CHECK_THAT(complaint(""), contains("is empty"));
  CHECK(complaint("a,b\n").empty());
}

TEST_CASE("a folder that cannot be written is found out at once") {
  const TemporaryFolder folder;
  make_output_folder(folder / "new/deep");
  CHECK(std::filesystem::is_directory(folder / "new/deep"));
  CHECK(std::filesystem::is_empty(folder / "new/deep"));
  write_file(folder / "file", "");
  CHECK_THROWS_WITH(make_output_folder(folder / "file"), contains("cannot be created"));
  CHECK_THROWS_WITH(make_output_folder(folder / "file/below"), contains("cannot be created"));
  CHECK_THROWS_WITH(make_output_folder("/proc/nothing"), contains("cannot be"));
  CHECK_THROWS_AS(CsvWriter(folder / "file/curve.csv", columns), Error);
}
