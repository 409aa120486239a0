// SPDX-License-Identifier: MIT
#pragma once

#include <stdexcept>
#include <string>

namespace jampack {

/// Anything jampack reports: one line that says what was wrong, where, and what would be right.
struct Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The caller's input cannot be used (programs end with exit code 2).
struct InvalidInput : Error {
  using Error::Error;
};

/// A computation did not converge or a state became impossible (programs end with exit code 1).
struct NotConverged : Error {
  using Error::Error;
};

/// Always-on check of what a caller passes; throws InvalidInput.
inline void require(bool condition, const std::string& message) {
  if (!condition) throw InvalidInput(message);
}

}  // namespace jampack
