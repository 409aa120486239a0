// SPDX-License-Identifier: MIT
#pragma once

// Catch2 2.13 and 3 alike.
#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
#else
#include <catch2/catch.hpp>
#endif

#include <string>

namespace jampack_tests {

/// Matcher: the text, or the message of a thrown exception, contains this. Catch2 3 renamed its own.
inline auto contains(const std::string& part) {
#if __has_include(<catch2/catch_all.hpp>)
  return Catch::Matchers::ContainsSubstring(part);
#else
  return Catch::Matchers::Contains(part);
#endif
}

}  // namespace jampack_tests
