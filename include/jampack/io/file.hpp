// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <fstream>
#include <jampack/core/error.hpp>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>

namespace jampack {

/// Writes a whole file so that whoever reads the path, also after a crash, finds the old content or the new,
/// never half of it: the content goes to `path` + ".part" first, which is then renamed.
/// Throws Error where that fails.
inline void write_file(const std::filesystem::path& path, std::string_view content) {
  std::filesystem::path part = path;
  part += ".part";
  {
    std::ofstream stream(part, std::ios::binary);
    stream.write(content.data(), static_cast<std::streamsize>(content.size()));
    stream.flush();
    if (!stream) throw Error("cannot write " + part.string());
  }
  std::error_code failure;
  std::filesystem::rename(part, path, failure);
  if (failure) throw Error("cannot write " + path.string() + ": " + failure.message());
}

/// The whole content of a file; throws InvalidInput where it cannot be read.
inline std::string read_file(const std::filesystem::path& path) {
  std::error_code failure;
  require(std::filesystem::is_regular_file(path, failure), "cannot read " + path.string() + ": no such file");
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream content;
  content << stream.rdbuf();
  require(stream.good() || stream.eof(), "cannot read " + path.string());
  return content.str();
}

/// Creates the folder if need be and proves that it can be written, so that a long run does not end with the
/// discovery that it cannot. Throws InvalidInput.
inline void make_output_folder(const std::filesystem::path& folder) {
  std::error_code failure;
  std::filesystem::create_directories(folder, failure);
  require(std::filesystem::is_directory(folder, failure),
          "the output folder " + folder.string() + " cannot be created");
  const std::filesystem::path probe = folder / ".jampack_can_write";
  const bool can_write = static_cast<bool>(std::ofstream(probe) << '\n' << std::flush);
  std::filesystem::remove(probe, failure);
  require(can_write, "the output folder " + folder.string() + " cannot be written");
}

}  // namespace jampack
