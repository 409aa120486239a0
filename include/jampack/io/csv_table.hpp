// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <filesystem>
#include <jampack/core/array.hpp>
#include <jampack/core/error.hpp>
#include <jampack/io/file.hpp>
#include <jampack/io/number.hpp>
#include <limits>
#include <string>
#include <string_view>

namespace jampack {

/// The numbers of a CSV file, column by column; an empty cell is NaN.
struct CsvTable {
  Array<std::string> names;      ///< of the columns, as in the first line
  Array<Array<double>> columns;  ///< one a name, all of n_rows() numbers

  Index n_rows() const { return columns.empty() ? 0 : columns[0].size(); }

  /// Throws InvalidInput where there is no such column.
  const Array<double>& column(std::string_view name) const {
    for (Index i = 0; i < names.size(); ++i)
      if (names[i] == name) return columns[i];
    throw InvalidInput("there is no column '" + std::string(name) + "'");
  }
};

namespace detail {

inline Array<std::string_view> split(std::string_view text, char separator) {
  Array<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

}  // namespace detail

/// Reads a CSV file of numbers under one line of names, as CsvWriter writes it. Throws InvalidInput, with the
/// line, for a cell that is no number, a row of the wrong length or a last line cut short.
inline CsvTable read_csv(const std::filesystem::path& path) {
  const std::string content = read_file(path);
  require(content.ends_with('\n'), path.string() + " is empty or its last line is cut short");
  const auto lines = detail::split(std::string_view(content).substr(0, content.size() - 1), '\n');

  CsvTable table;
  for (const std::string_view name : detail::split(lines[0], ',')) table.names.emplace_back(name);
  table.columns.resize(table.names.size());
  for (Index i = 1; i < lines.size(); ++i) {
    const std::string where = path.string() + ", line " + std::to_string(i + 1);
    const auto cells = detail::split(lines[i], ',');
    require(cells.size() == table.names.size(), where + ": " + std::to_string(cells.size()) + " cells for " +
                                                    std::to_string(table.names.size()) + " columns");
    for (Index j = 0; j < cells.size(); ++j) {
      const auto number =
          cells[j].empty() ? std::numeric_limits<double>::quiet_NaN() : to_number<double>(cells[j]);
      require(number.has_value(), where + ": '" + std::string(cells[j]) + "' is not a number");
      table.columns[j].push_back(*number);
    }
  }
  return table;
}

}  // namespace jampack
