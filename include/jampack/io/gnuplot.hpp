// SPDX-License-Identifier: MIT
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>

namespace jampack {

/// A text as a single-quoted string of a gnuplot script.
inline std::string gnuplot_quoted(std::string_view text) {
  std::string quoted = "'";
  for (const char character : text) quoted += character == '\'' ? "''" : std::string(1, character);
  return quoted + "'";
}

/// Runs a gnuplot script in its own folder; false where gnuplot is not installed or fails.
inline bool run_gnuplot(const std::filesystem::path& script) {
  const auto shell_quoted = [](const std::string& text) {
    std::string quoted = "'";
    for (const char character : text) quoted += character == '\'' ? "'\\''" : std::string(1, character);
    return quoted + "'";
  };
  const std::string folder = script.has_parent_path() ? script.parent_path().string() : ".";
  const std::string command = "cd -- " + shell_quoted(folder) + " && gnuplot " +
                              shell_quoted("./" + script.filename().string()) + " >/dev/null 2>&1";
  return std::system(command.c_str()) == 0;
}

}  // namespace jampack
