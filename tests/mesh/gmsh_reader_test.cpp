// SPDX-License-Identifier: MIT
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <jampack/mesh/ball_mesh.hpp>
#include <jampack/mesh/disk_mesh.hpp>
#include <jampack/mesh/gmsh_reader.hpp>
#include <string>

#include "../catch.hpp"

using namespace jampack;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using jampack_tests::contains;

namespace {

/// A file that is gone when the test ends.
struct TemporaryFile {
  std::filesystem::path path;
  explicit TemporaryFile(const std::string& text, const std::string& name = "jampack_gmsh_reader_test.msh")
      : path(std::filesystem::temp_directory_path() / name) {
    std::ofstream(path) << text;
  }
  ~TemporaryFile() { std::filesystem::remove(path); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
};

/// Writes a mesh as Gmsh would: numbers with gaps, boundary elements first, every other cell turned inside
/// out.
template <int Dim>
std::string gmsh_text(const Mesh<Dim>& mesh, bool second_order) {
  std::string text =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"grain\"\n$EndPhysicalNames\n$Nodes\n";
  text += std::to_string(mesh.nodes.size()) + "\n";
  const auto number = [](Index i) { return std::to_string(7 + 3 * i); };
  for (Index i = 0; i < mesh.nodes.size(); ++i) {
    char line[100];
    std::snprintf(line, sizeof line, "%s %.17g %.17g %.17g\n", number(i).c_str(), mesh.nodes[i][0],
                  mesh.nodes[i][1], Dim == 3 ? mesh.nodes[i][Dim - 1] : 0.0);
    text += line;
  }
  const Index n_cells = second_order ? mesh.macros.size() : mesh.cells.size();
  text += "$EndNodes\n$Elements\n" + std::to_string(n_cells + 1) + "\n1 15 2 0 1 " + number(0) + "\n";
  for (Index c = 0; c < n_cells; ++c) {
    text += std::to_string(c + 2);
    text += second_order ? (Dim == 2 ? " 9" : " 11") : (Dim == 2 ? " 2" : " 4");
    text += " 2 1 1";
    const bool turned = c % 2 == 1;
    if (second_order) {
      // Gmsh's order of mid nodes in 3D: 01 12 20 03 23 13; a turned cell exchanges corners 0 and 1.
      constexpr std::array<std::size_t, 10> as_is{0, 1, 2, 3, 4, 5, 6, 7, 9, 8},
          inside_out{1, 0, 2, 3, 4, 6, 5, 8, 9, 7};
      constexpr std::array<std::size_t, 6> flat{0, 1, 2, 3, 4, 5}, flat_turned{1, 0, 2, 3, 5, 4};
      for (std::size_t i = 0; i < static_cast<std::size_t>(Mesh<Dim>::n_macro_nodes); ++i) {
        std::size_t j = 0;
        if constexpr (Dim == 3)
          j = turned ? inside_out[i] : as_is[i];
        else
          j = turned ? flat_turned[i] : flat[i];
        text += " " + number(mesh.macros[c][j]);
      }
    } else {
      auto cell = mesh.cells[c];
      if (turned) std::swap(cell[0], cell[1]);
      for (const Index i : cell) text += " " + number(i);
    }
    text += "\n";
  }
  return text + "$EndElements\n";
}

const std::string header = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
const std::string four_nodes = "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n";

}  // namespace

TEMPLATE_TEST_CASE_SIG("a mesh written in Gmsh's format is read back, first and second order", "",
                       ((int Dim), Dim), 2, 3) {
  const auto mesh = [] {
    if constexpr (Dim == 2)
      return disk_mesh(100);
    else
      return ball_mesh(100);
  }();
  for (const bool second_order : {false, true}) {
    const TemporaryFile file(gmsh_text(mesh, second_order));
    const auto read = read_gmsh<Dim>(file.path);
    CHECK(read.nodes.size() == mesh.nodes.size());
    CHECK(read.cells.size() == mesh.cells.size());
    CHECK(read.macros.size() == (second_order ? mesh.macros.size() : 0));
    CHECK(read.boundary_nodes.size() == mesh.boundary_nodes.size());
    CHECK(read.faces.size() == (second_order ? 1 : Mesh<Dim>::n_cells_a_macro / 2) * mesh.faces.size());
    CHECK_THAT(mesh_volume(read), WithinRel(mesh_volume(mesh), 1e-13));
    const auto quality = mesh_quality(read), expected = mesh_quality(mesh);
    CHECK_THAT(quality.min_radius_ratio, WithinRel(expected.min_radius_ratio, 1e-9));
    if (second_order) CHECK_THAT(quality.min_scaled_jacobian, WithinRel(expected.min_scaled_jacobian, 1e-9));
    for (const auto& face : read.faces)
      for (Index i = 0; i < face.n_nodes; ++i)
        CHECK_THAT(read.nodes[face.node[static_cast<std::size_t>(i)]].norm(), WithinAbs(0.5, 1e-15));
  }
}

TEST_CASE("what is not a usable Gmsh mesh is refused with file and line") {
  const std::string end = "$EndElements\n";
  struct Case {
    std::string text, says;
  };
  const Case cases[] = {
      {"", ":0: the file has no $Elements"},
      {"solid ball\n", ":1: not a Gmsh file"},
      {"$Nodes\n4\n", ":1: not a Gmsh file"},
      {"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n", ":2: only ASCII files of Gmsh's format 2.2"},
      {"$MeshFormat\n2.2 1 8\n", ":2: only ASCII files of Gmsh's format 2.2"},
      {header + "$Nodes\nmany\n", ":5: the number of nodes is expected, not \"many\""},
      {header + "$Nodes\n-3\n", ":5: the number of nodes is expected"},
      {header + "$Nodes\n2\n1 0 0 0\n2 0 0\n", ":7: a node is \"number x y z\""},
      {header + "$Nodes\n2\n1 0 0 0\n1 1 0 0\n", ":7: node 1 appears twice"},
      {header + "$Nodes\n1\n1 0 inf 0\n", ":6: a"},
      {header + "$Nodes\n3\n1 0 0 0\n", ":7: the file ends where a node should be"},
      {header + "$Nodes\n1\n1 0 0 0\n2 0 0 0\n", ":7: $EndNodes is expected"},
      {header + "$Elements\n1\n", ":4: $Elements before $Nodes"},
      {header + four_nodes, ":10: the file has no $Elements"},
      {header + four_nodes + "$Elements\n1\n1 4 2 1 1 1 2 3 9\n" + end, ":13: node 9 does not exist"},
      {header + four_nodes + "$Elements\n1\n1 4 2 1 1 1 2 3\n" + end, ":13: an element has fewer nodes"},
      {header + four_nodes + "$Elements\n1\n1 4 9 1 1 1\n" + end, ":13: an element has fewer tags"},
      {header + four_nodes + "$Elements\n1\n1 4 2 1 1 1 2 3 3\n" + end, ":13: a cell is flat"},
      {header + four_nodes + "$Elements\n2\n1 4 2 1 1 1 2 3 4\n",
       ":14: the file ends where an element should be"},
      {header + four_nodes + "$Elements\n1\n1 4 2 1 1 1 2 3 4\n", ":14: the file ends where $EndElements"},
      {header + four_nodes + "$Elements\n1\n1 2 2 1 1 1 2 3\n" + end, ":14: the file has no tetrahedra"},
      {header + four_nodes + "$Elements\n3\n1 4 0 1 2 3 4\n2 4 0 1 2 3 4\n3 4 0 1 2 3 4\n" + end,
       "a face belongs to more than two cells"},
      {header + "$Comments\nwithout end\n", ":6: the file ends where $EndComments should be"},
  };
  for (const auto& [text, says] : cases) {
    INFO(text);
    const TemporaryFile file(text);
    CHECK_THROWS_AS(read_gmsh<3>(file.path), InvalidInput);
    CHECK_THROWS_WITH(read_gmsh<3>(file.path), contains(says) && contains(file.path.string()));
  }
  CHECK_THROWS_WITH(read_gmsh<3>("/no/such/file.msh"), contains("cannot read /no/such/file.msh"));
  // The good file of which the bad ones are variants.
  const TemporaryFile good(header + four_nodes + "$Elements\n1\n1 4 2 1 1 1 2 3 4\n" + end);
  CHECK_THAT(mesh_volume(read_gmsh<3>(good.path)), WithinRel(1.0 / 6, 1e-14));
  // Its triangles do not lie in the plane z = 0.
  CHECK_THROWS_WITH(read_gmsh<2>(good.path), contains(":9: a 2D mesh must lie in the plane z = 0"));
}

TEST_CASE("a second-order cell folded by its mid nodes is refused") {
  auto mesh = disk_mesh(100);
  const auto macro = mesh.macros[3];
  mesh.nodes[macro[3]] = 0.9 * mesh.nodes[macro[0]] + 0.1 * mesh.nodes[macro[1]];
  const TemporaryFile file(gmsh_text(mesh, true));
  CHECK_THROWS_WITH(read_gmsh<2>(file.path), contains("a second-order cell is inverted"));
}
