// SPDX-License-Identifier: MIT
#pragma once

#include <exception>
#include <filesystem>
#include <iostream>
#include <jampack/core/array.hpp>
#include <jampack/core/error.hpp>
#include <jampack/io/command_line.hpp>
#include <string>
#include <utility>

namespace jampack {

/// The main of a program: calls body(CommandLine&) and turns how it ends into an exit code.
///
///   0  it returned (a body that returns int gives the code itself)
///   1  NotConverged or any other failure
///   2  InvalidInput
///
/// A failure prints one line "program: message" to `errors`, never a trace.
template <class Body>
int run_program(int argc, const char* const* argv, std::string purpose, Body&& body,
                std::ostream& errors = std::cerr) {
  const std::string program =
      argc > 0 ? std::filesystem::path(argv[0]).filename().string() : std::string("jampack");
  const auto report = [&](std::string message, int code) {
    for (char& character : message)
      if (character == '\n') character = ' ';
    errors << program << ": " << message << std::endl;
    return code;
  };
  try {
    CommandLine line(program, std::move(purpose), Array<std::string>(argv + (argc > 0 ? 1 : 0), argv + argc));
    if constexpr (std::is_same_v<decltype(body(line)), int>) {
      return body(line);
    } else {
      body(line);
      return 0;
    }
  } catch (const InvalidInput& error) {
    return report(error.what(), 2);
  } catch (const std::bad_alloc&) {
    return report("out of memory", 1);
  } catch (const std::exception& error) {
    return report(error.what(), 1);
  }
}

}  // namespace jampack
