// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <jampack/core/error.hpp>
#include <jampack/mesh/boundary.hpp>
#include <jampack/mesh/mesh.hpp>
#include <jampack/mesh/refinement.hpp>
#include <map>
#include <sstream>
#include <string>
#include <utility>

namespace jampack {

/// The lines of a text file with their numbers, so that every complaint names file and line.
class NumberedLines {
 public:
  explicit NumberedLines(const std::filesystem::path& path) : path_(path), input_(path) {
    require(input_.good(), "cannot read " + path.string());
  }
  /// Next line; throws InvalidInput, naming what was expected, if the file ends.
  std::string next(const std::string& expected) {
    std::string line;
    if (!std::getline(input_, line)) {
      ++number_;
      fail("the file ends where " + expected + " should be");
    }
    ++number_;
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    return line;
  }
  bool at_end() { return input_.peek() == std::ifstream::traits_type::eof(); }
  [[noreturn]] void fail(const std::string& why) const {
    throw InvalidInput(path_.string() + ":" + std::to_string(number_) + ": " + why);
  }

 private:
  std::filesystem::path path_;
  std::ifstream input_;
  long number_ = 0;
};

namespace detail {

/// Reads one count, which must be the only thing on its line.
inline Index read_count(NumberedLines& lines, const std::string& what) {
  const std::string text = lines.next("the number of " + what);
  std::istringstream words(text);
  Index count = -1;
  std::string rest;
  if (!(words >> count) || count < 0 || (words >> rest))
    lines.fail("the number of " + what + " is expected, not \"" + text + "\"");
  return count;
}

inline void expect_line(NumberedLines& lines, const std::string& keyword) {
  const std::string text = lines.next(keyword);
  if (text != keyword) lines.fail(keyword + " is expected, not \"" + text + "\"");
}

}  // namespace detail

/// Reads a mesh of triangles (Dim = 2, in the plane z = 0) or tetrahedra (Dim = 3) from an ASCII file of
/// Gmsh's format 2.2; other elements (points, lines, the surface) are passed over and the boundary is found
/// from the cells. A file of second-order elements gives macros and their refinement; both orders in one file
/// are refused. Cells numbered against the orientation convention are renumbered; flat cells, and
/// second-order cells that are inverted anywhere at their nodes, are refused. Nodes of no cell are left out.
///
/// Throws InvalidInput, one line with file and line number, for anything that is not such a mesh.
template <int Dim>
Mesh<Dim> read_gmsh(const std::filesystem::path& path) {
  constexpr Index linear_type = Dim == 2 ? 2 : 4, quadratic_type = Dim == 2 ? 9 : 11;
  constexpr auto n_macro_nodes = static_cast<std::size_t>(Mesh<Dim>::n_macro_nodes);
  NumberedLines lines(path);
  Mesh<Dim> mesh;
  std::map<Index, Vector<Dim>> position;  // by the file's numbers
  std::map<Index, Index> index;           // file number -> node, in the order of first use
  bool has_format = false, has_nodes = false, has_elements = false;

  const auto node = [&](Index number) {
    const auto found = position.find(number);
    if (found == position.end()) lines.fail("node " + std::to_string(number) + " does not exist");
    const auto [entry, is_new] = index.try_emplace(number, mesh.nodes.size());
    if (is_new) mesh.nodes.push_back(found->second);
    return entry->second;
  };
  const auto read_nodes = [&] {
    const Index n = detail::read_count(lines, "nodes");
    for (Index i = 0; i < n; ++i) {
      const std::string text = lines.next("a node");
      std::istringstream words(text);
      Index number = 0;
      std::array<double, 3> x{};
      if (!(words >> number >> x[0] >> x[1] >> x[2]))
        lines.fail("a node is \"number x y z\", not \"" + text + "\"");
      if (!std::isfinite(x[0] + x[1] + x[2])) lines.fail("a coordinate is not finite");
      if (Dim == 2 && x[2] != 0) lines.fail("a 2D mesh must lie in the plane z = 0");
      Vector<Dim> at;
      for (int d = 0; d < Dim; ++d) at[d] = x[static_cast<std::size_t>(d)];
      if (!position.emplace(number, at).second)
        lines.fail("node " + std::to_string(number) + " appears twice");
    }
    detail::expect_line(lines, "$EndNodes");
  };
  const auto read_element = [&](const std::string& text) {
    std::istringstream words(text);
    Index number = 0, type = 0, n_tags = 0, tag = 0;
    if (!(words >> number >> type >> n_tags) || n_tags < 0)
      lines.fail("an element is \"number type tags... nodes...\", not \"" + text + "\"");
    for (Index i = 0; i < n_tags; ++i)
      if (!(words >> tag)) lines.fail("an element has fewer tags than it says");
    if (type != linear_type && type != quadratic_type) return;
    std::array<Index, n_macro_nodes> macro{};
    const std::size_t n_nodes = type == linear_type ? Dim + 1 : n_macro_nodes;
    for (std::size_t i = 0; i < n_nodes; ++i) {
      Index file_number = 0;
      if (!(words >> file_number)) lines.fail("an element has fewer nodes than its type asks for");
      macro[i] = node(file_number);
    }
    if constexpr (Dim == 3) std::swap(macro[8], macro[9]);  // Gmsh numbers edge 23 before edge 13
    std::array<Index, Dim + 1> corners{};
    for (std::size_t i = 0; i <= Dim; ++i) corners[i] = macro[i];
    double size = 0;
    for (std::size_t i = 1; i <= Dim; ++i)
      size = std::max(size, (mesh.nodes[corners[i]] - mesh.nodes[corners[0]]).norm());
    const double determinant = simplex_determinant<Dim>(mesh.nodes, corners);
    if (!(std::abs(determinant) > 1e-10 * std::pow(size, Dim))) lines.fail("a cell is flat");
    if (determinant < 0) {
      // Exchanging corners 0 and 1 exchanges edges 12 and 20, and 03 and 13.
      std::swap(corners[0], corners[1]);
      std::swap(macro[0], macro[1]);
      std::swap(macro[Dim + 2], macro[Dim + 3]);
      if constexpr (Dim == 3) std::swap(macro[7], macro[8]);
    }
    if (type == linear_type) {
      if (!mesh.macros.empty()) lines.fail("first- and second-order cells in one file");
      mesh.cells.push_back(corners);
      return;
    }
    if (!mesh.cells.empty()) lines.fail("first- and second-order cells in one file");
    for (const auto& cell : refine_macro<Dim>(mesh.nodes, macro))
      if (!(radius_ratio<Dim>(mesh.nodes, cell) > 0)) lines.fail("a second-order cell is inverted");
    if (!(macro_jacobian_range<Dim>(mesh.nodes, macro).first > 0))
      lines.fail("a second-order cell is inverted");
    mesh.macros.push_back(macro);
  };

  while (!lines.at_end()) {
    const std::string section = lines.next("a section");
    if (section.empty()) continue;
    if (section == "$MeshFormat") {
      std::istringstream words(lines.next("the format"));
      std::string version;
      int binary = 1;
      words >> version >> binary;
      if (version.rfind("2.", 0) != 0 || binary != 0)
        lines.fail("only ASCII files of Gmsh's format 2.2 are read (gmsh -format msh22)");
      detail::expect_line(lines, "$EndMeshFormat");
      has_format = true;
    } else if (!has_format) {
      lines.fail("not a Gmsh file: $MeshFormat is expected");
    } else if (section == "$Nodes") {
      read_nodes();
      has_nodes = true;
    } else if (section == "$Elements") {
      if (!has_nodes) lines.fail("$Elements before $Nodes");
      const Index n = detail::read_count(lines, "elements");
      for (Index i = 0; i < n; ++i) read_element(lines.next("an element"));
      detail::expect_line(lines, "$EndElements");
      has_elements = true;
    } else if (section.size() > 1 && section[0] == '$') {
      const std::string end = "$End" + section.substr(1);
      while (lines.next(end) != end) {
      }
    } else {
      lines.fail("a section is expected, not \"" + section + "\"");
    }
  }
  if (!has_elements) lines.fail("the file has no $Elements");
  if (mesh.cells.empty() && mesh.macros.empty())
    lines.fail(std::string("the file has no ") + (Dim == 2 ? "triangles" : "tetrahedra"));
  if (!mesh.macros.empty()) mesh.cells = refine_macros<Dim>(mesh.nodes, mesh.macros);
  try {
    find_boundary(mesh);
  } catch (const InvalidInput& error) {
    throw InvalidInput(path.string() + ": " + error.what());
  }
  return mesh;
}

}  // namespace jampack
