// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <jampack/core/array.hpp>
#include <jampack/core/error.hpp>
#include <jampack/io/file.hpp>
#include <jampack/io/number.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace jampack {

/// One cell of a CSV row: a number written so that it reads back exactly, or a text (RFC 4180 quotes where
/// needed). NaN, "there is none", is an empty cell.
struct CsvCell {
  std::string text;

  template <Number T>
  CsvCell(T number) : text(to_text(number)) {
    if constexpr (std::floating_point<T>)
      if (std::isnan(number)) text.clear();
  }
  CsvCell(std::string_view content) : text(content) {
    if (text.find_first_of(",\"\n\r") == std::string::npos) return;
    text = "\"";
    for (const char character : content) text += character == '"' ? "\"\"" : std::string(1, character);
    text += '"';
  }
  CsvCell(const char* content) : CsvCell(std::string_view(content)) {}
  CsvCell(const std::string& content) : CsvCell(std::string_view(content)) {}
};

/// A CSV file with named columns that grows by one whole row at a time; each row is handed to the system
/// before write() returns, so that a killed run leaves at most one unfinished line, which resume() drops.
class CsvWriter {
 public:
  /// Starts a new file in place of any old one. Throws Error if it cannot be written.
  CsvWriter(std::filesystem::path path, const Array<std::string>& columns)
      : path_(std::move(path)), n_columns_(columns.size()) {
    start(header(columns));
  }

  /// Cuts an existing file back to its first n_rows rows and goes on after them. Throws InvalidInput if the
  /// file has other columns or fewer whole rows.
  static CsvWriter resume(std::filesystem::path path, const Array<std::string>& columns, Index n_rows) {
    const std::string content = read_file(path);
    const std::string first_line = header(columns);
    require(content.starts_with(first_line), path.string() + " has other columns than this program writes");
    std::size_t end = first_line.size();
    for (Index row = 0; row < n_rows; ++row) {
      const std::size_t line_end = content.find('\n', end);
      require(line_end != std::string::npos, path.string() + " has only " + std::to_string(row) + " of the " +
                                                 std::to_string(n_rows) + " rows to go on from");
      end = line_end + 1;
    }
    return CsvWriter(std::move(path), columns.size(), content.substr(0, end));
  }

  /// Appends a row, one cell a column.
  void write(std::span<const CsvCell> row) {
    require(static_cast<Index>(row.size()) == n_columns_, path_.string() + ": a row of " +
                                                              std::to_string(row.size()) + " cells for " +
                                                              std::to_string(n_columns_) + " columns");
    stream_ << line(row) << std::flush;
    if (!stream_) throw Error("cannot write " + path_.string());
  }
  void write(std::initializer_list<CsvCell> row) { write(std::span(row.begin(), row.size())); }
  void write(const Array<double>& row) {
    const Array<CsvCell> cells(row.begin(), row.end());
    write(std::span(cells.data(), static_cast<std::size_t>(cells.size())));
  }

 private:
  CsvWriter(std::filesystem::path path, Index n_columns, const std::string& content)
      : path_(std::move(path)), n_columns_(n_columns) {
    start(content);
  }

  void start(const std::string& content) {
    write_file(path_, content);
    stream_.open(path_, std::ios::binary | std::ios::app);
    if (!stream_) throw Error("cannot write " + path_.string());
  }

  static std::string header(const Array<std::string>& columns) {
    const Array<CsvCell> cells(columns.begin(), columns.end());
    return line(std::span(cells.data(), static_cast<std::size_t>(cells.size())));
  }

  static std::string line(std::span<const CsvCell> cells) {
    std::string text;
    for (const CsvCell& cell : cells) {
      if (&cell != cells.data()) text += ',';
      text += cell.text;
    }
    return text + '\n';
  }

  std::filesystem::path path_;
  Index n_columns_ = 0;
  std::ofstream stream_;
};

}  // namespace jampack
