// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <jampack/core/array.hpp>
#include <jampack/core/error.hpp>
#include <jampack/io/file.hpp>
#include <jampack/io/number.hpp>
#include <string>
#include <utility>

namespace jampack {

/// A ParaView collection: which VTU files belong to which time. The file on disk is complete after each
/// add().
class PvdSeries {
 public:
  /// Starts a new collection in place of any old one.
  explicit PvdSeries(std::filesystem::path path) : path_(std::move(path)) { write(); }

  /// Keeps the first n_entries entries of a collection written before. Throws InvalidInput if there are
  /// fewer.
  static PvdSeries resume(std::filesystem::path path, Index n_entries) {
    Array<std::string> entries;
    const std::string content = read_file(path);
    for (std::size_t begin = 0; entries.size() < n_entries;) {
      begin = content.find("<DataSet ", begin);
      const std::size_t end = content.find("/>\n", begin);
      require(begin != std::string::npos && end != std::string::npos,
              path.string() + " has only " + std::to_string(entries.size()) + " of the " +
                  std::to_string(n_entries) + " entries to go on from");
      entries.push_back(content.substr(begin, end + 3 - begin));
      begin = end;
    }
    return PvdSeries(std::move(path), std::move(entries));
  }

  /// A file at a time (any increasing number); parts of one time are shown together. The file is named
  /// relative to the collection's folder, so that the folder can be moved.
  void add(double time, const std::filesystem::path& file, int part = 0) {
    const auto folder = path_.has_parent_path() ? path_.parent_path() : std::filesystem::path(".");
    const std::string relative = std::filesystem::relative(file, folder).generic_string();
    require(relative.find_first_of("\"<&") == std::string::npos, relative + " cannot be named in a PVD file");
    entries_.push_back("<DataSet timestep=\"" + to_text(time) + "\" part=\"" + std::to_string(part) +
                       "\" file=\"" + relative + "\"/>\n");
    write();
  }

  Index n_entries() const { return entries_.size(); }

 private:
  PvdSeries(std::filesystem::path path, Array<std::string> entries)
      : path_(std::move(path)), entries_(std::move(entries)) {
    write();
  }

  void write() const {
    std::string text =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n";
    for (const std::string& entry : entries_) text += entry;
    write_file(path_, text + "</Collection>\n</VTKFile>\n");
  }

  std::filesystem::path path_;
  Array<std::string> entries_;
};

}  // namespace jampack
