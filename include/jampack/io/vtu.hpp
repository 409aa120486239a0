// SPDX-License-Identifier: MIT
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <initializer_list>
#include <jampack/core/array.hpp>
#include <jampack/core/dimension.hpp>
#include <jampack/core/error.hpp>
#include <jampack/io/file.hpp>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

namespace jampack {

/// VTK's codes of the cells jampack writes. The quadratic ones list corners first, then mid nodes in the
/// order 01, 12, 20, and for the tetrahedron 03, 13, 23.
enum class VtkCell : std::uint8_t {
  vertex = 1,
  line = 3,
  triangle = 5,
  polygon = 7,
  tetrahedron = 10,
  quadratic_triangle = 22,
  quadratic_tetrahedron = 24
};

/// One value a point or a cell: a scalar, or a vector with its third component zero in 2D.
struct VtuField {
  std::string name;
  int n_components;      ///< 1 or 3
  Array<double> values;  ///< n_components each, one after another

  VtuField(std::string field_name, const Array<double>& scalars)
      : name(std::move(field_name)), n_components(1), values(scalars) {}
  template <int Dim>
  VtuField(std::string field_name, const Array<Vector<Dim>>& vectors)
      : name(std::move(field_name)), n_components(3) {
    values.reserve(3 * vectors.size());
    for (const Vector<Dim>& vector : vectors)
      for (int axis = 0; axis < 3; ++axis) values.push_back(axis < Dim ? vector[axis] : 0.0);
  }
};

/// An unstructured grid with data, as ParaView shows it.
struct VtuGrid {
  Array<Vector<3>> points;
  Array<Index> connectivity;  ///< the points of all cells, cell after cell
  Array<Index> offsets;       ///< where each cell ends in connectivity
  Array<VtkCell> types;       ///< one a cell
  Array<VtuField> point_data;
  Array<VtuField> cell_data;

  /// Returns the number of the new point; z = 0 in 2D.
  template <int Dim>
  Index add_point(const Eigen::Matrix<double, Dim, 1>& point) {
    static_assert(SupportedDimension<Dim>);
    points.push_back(Vector<3>(point[0], point[1], Dim == 3 ? point[Dim - 1] : 0.0));
    return points.size() - 1;
  }
  /// The cell's points, shifted by first_point (the number of its grain's first point).
  template <class Nodes>
  void add_cell(VtkCell type, const Nodes& nodes, Index first_point = 0) {
    for (const Index node : nodes) connectivity.push_back(first_point + node);
    offsets.push_back(connectivity.size());
    types.push_back(type);
  }
  void add_cell(VtkCell type, std::initializer_list<Index> nodes, Index first_point = 0) {
    add_cell<std::initializer_list<Index>>(type, nodes, first_point);
  }
};

namespace detail {

/// The <AppendedData> block of a VTU file, and the DataArray elements that point into it.
class VtuAppendedData {
 public:
  template <class Stored, class Values>
  std::string array(std::string_view name, std::string_view vtk_type, int n_components,
                    const Values& values) {
    const std::string element = "<DataArray type=\"" + std::string(vtk_type) + "\" Name=\"" + escaped(name) +
                                "\" NumberOfComponents=\"" + std::to_string(n_components) +
                                "\" format=\"appended\" offset=\"" + std::to_string(bytes_.size()) + "\"/>\n";
    append(static_cast<std::uint64_t>(values.size()) * sizeof(Stored));
    for (const auto value : values) append(static_cast<Stored>(value));
    return element;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  template <class T>
  void append(T value) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    bytes_.append(bytes, sizeof(T));
  }
  static std::string escaped(std::string_view text) {
    std::string result;
    for (const char character : text) {
      if (character == '&')
        result += "&amp;";
      else if (character == '<')
        result += "&lt;";
      else if (character == '"')
        result += "&quot;";
      else
        result += character;
    }
    return result;
  }
  std::string bytes_;
};

}  // namespace detail

/// Writes a VTU file (VTK XML, raw appended data). Points and fields are in single precision: made to be
/// looked at, a checkpoint holds the state. Throws InvalidInput where a field's length is not that of the
/// points or cells, or a cell names a point that does not exist.
inline void write_vtu(const std::filesystem::path& path, const VtuGrid& grid) {
  const Index n_points = grid.points.size();
  const Index n_cells = grid.types.size();
  require(grid.offsets.size() == n_cells, "VTU: as many offsets as cell types are needed");
  require(n_cells == 0 || grid.offsets.back() == grid.connectivity.size(),
          "VTU: offsets end before the cells");
  for (const Index node : grid.connectivity)
    require(node >= 0 && node < n_points,
            "VTU: a cell names point " + std::to_string(node) + " of " + std::to_string(n_points));
  for (const auto* fields : {&grid.point_data, &grid.cell_data})
    for (const VtuField& field : *fields)
      require(field.values.size() == (fields == &grid.point_data ? n_points : n_cells) * field.n_components,
              "VTU: field '" + field.name + "' has the wrong length");

  detail::VtuAppendedData data;
  const auto field_elements = [&data](const Array<VtuField>& fields) {
    std::string text;
    for (const VtuField& field : fields)
      text += data.array<float>(field.name, "Float32", field.n_components, field.values);
    return text;
  };
  Array<double> coordinates;
  coordinates.reserve(3 * n_points);
  for (const Vector<3>& point : grid.points)
    for (int axis = 0; axis < 3; ++axis) coordinates.push_back(point[axis]);

  const std::string order = std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian";
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"" + order +
      "\" header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"" + std::to_string(n_points) +
      "\" NumberOfCells=\"" + std::to_string(n_cells) + "\">\n";
  text += "<Points>\n" + data.array<float>("Points", "Float32", 3, coordinates) + "</Points>\n<Cells>\n";
  text += data.array<std::int32_t>("connectivity", "Int32", 1, grid.connectivity);
  text += data.array<std::int32_t>("offsets", "Int32", 1, grid.offsets);
  text += data.array<std::uint8_t>("types", "UInt8", 1, grid.types);
  text += "</Cells>\n<PointData>\n" + field_elements(grid.point_data) + "</PointData>\n";
  text += "<CellData>\n" + field_elements(grid.cell_data) + "</CellData>\n";
  text += "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
  text += data.bytes();
  text += "\n</AppendedData>\n</VTKFile>\n";
  write_file(path, text);
}

}  // namespace jampack
