// SPDX-License-Identifier: MIT
#include <cstring>
#include <jampack/io/pvd.hpp>
#include <jampack/io/vtu.hpp>
#include <vector>

#include "../catch.hpp"
#include "temporary_folder.hpp"

using namespace jampack;
using jampack_tests::contains;
using jampack_tests::TemporaryFolder;

namespace {

/// Reads one array of a VTU file by the rules of the format, not by those of the writer.
template <class T>
std::vector<T> stored_array(const std::string& file, const std::string& name) {
  const auto element = file.find("Name=\"" + name + "\"");
  const auto offset_at = file.find("offset=\"", element) + 8;
  const auto offset = static_cast<std::size_t>(std::stoull(file.substr(offset_at)));
  const auto begin = file.find('_', file.find("<AppendedData")) + 1 + offset;
  std::uint64_t n_bytes = 0;
  std::memcpy(&n_bytes, file.data() + begin, sizeof n_bytes);
  std::vector<T> values(n_bytes / sizeof(T));
  std::memcpy(values.data(), file.data() + begin + sizeof n_bytes, n_bytes);
  return values;
}

}  // namespace

TEST_CASE("a VTU file holds the grid that was put in") {
  const TemporaryFolder folder;
  VtuGrid grid;
  grid.add_point(Vector<3>(9, 9, 9));
  const Index first = grid.add_point(Vector<3>(0, 0, 0));
  grid.add_point(Vector<3>(1, 0, 0));
  grid.add_point(Vector<3>(0, 1, 0));
  grid.add_point(Vector<3>(0, 0, 1));
  grid.add_cell(VtkCell::tetrahedron, std::array<Index, 4>{0, 1, 2, 3}, first);
  grid.add_cell(VtkCell::line, {0, 4});
  grid.add_cell(VtkCell::vertex, {2});
  grid.cell_data.emplace_back("von Mises <Pa>", Array<double>{0.5, 0, 0});
  grid.point_data.emplace_back("velocity", Array<Vector<3>>(5, Vector<3>(1, 2, 3)));
  write_vtu(folder / "a.vtu", grid);

  const std::string file = read_file(folder / "a.vtu");
  CHECK_THAT(file, contains("NumberOfPoints=\"5\" NumberOfCells=\"3\"") && contains("von Mises &lt;Pa>"));
  CHECK(stored_array<std::int32_t>(file, "connectivity") == std::vector<std::int32_t>{1, 2, 3, 4, 0, 4, 2});
  CHECK(stored_array<std::int32_t>(file, "offsets") == std::vector<std::int32_t>{4, 6, 7});
  CHECK(stored_array<std::uint8_t>(file, "types") == std::vector<std::uint8_t>{10, 3, 1});
  CHECK(stored_array<float>(file, "von Mises &lt;Pa>") == std::vector<float>{0.5, 0, 0});
  CHECK(stored_array<float>(file, "velocity").size() == 15);
  CHECK(stored_array<float>(file, "Points")[0] == 9);
}

TEST_CASE("2D points and vectors get a third component of zero") {
  const TemporaryFolder folder;
  VtuGrid grid;
  grid.add_point(Vector<2>(1, 2));
  grid.add_cell(VtkCell::vertex, {0});
  grid.point_data.emplace_back("force", Array<Vector<2>>{Vector<2>(3, 4)});
  write_vtu(folder / "a.vtu", grid);
  const std::string file = read_file(folder / "a.vtu");
  CHECK(stored_array<float>(file, "Points") == std::vector<float>{1, 2, 0});
  CHECK(stored_array<float>(file, "force") == std::vector<float>{3, 4, 0});
}

TEST_CASE("grids that no reader could show are refused") {
  const TemporaryFolder folder;
  VtuGrid grid;
  grid.add_point(Vector<2>(1, 2));
  write_vtu(folder / "points_only.vtu", grid);
  VtuGrid dangling = grid;
  dangling.add_cell(VtkCell::line, {0, 1});
  CHECK_THROWS_WITH(write_vtu(folder / "a.vtu", dangling), contains("names point 1 of 1"));
  VtuGrid short_field = grid;
  short_field.point_data.emplace_back("speed", Array<double>{});
  CHECK_THROWS_WITH(write_vtu(folder / "a.vtu", short_field), contains("'speed' has the wrong length"));
  CHECK_FALSE(std::filesystem::exists(folder / "a.vtu"));
}

TEST_CASE("a collection names its files relative to itself and can be resumed") {
  const TemporaryFolder folder;
  const auto path = folder / "packing.pvd";
  PvdSeries series(path);
  series.add(0.6, folder / "packing/0.vtu");
  series.add(0.6, folder / "packing/contacts0.vtu", 1);
  const std::string two = read_file(path);
  CHECK_THAT(
      two, contains("timestep=\"0.6\" part=\"1\" file=\"packing/contacts0.vtu\"") && contains("</VTKFile>"));
  series.add(0.7, folder / "packing/1.vtu");

  PvdSeries resumed = PvdSeries::resume(path, 2);
  CHECK(resumed.n_entries() == 2);
  CHECK(read_file(path) == two);
  CHECK_THROWS_WITH(PvdSeries::resume(path, 3), contains("only 2 of the 3 entries"));
}
