// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <charconv>
#include <concepts>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace jampack {

/// A type read and written as a number (bool and characters are not).
template <class T>
concept Number = std::floating_point<T> ||(std::integral<T> && sizeof(T) > 1 && !std::same_as<T, bool>);

/// The shortest decimal text that reads back as exactly this number; independent of the locale.
template <Number T>
std::string to_text(T number) {
  std::array<char, 64> buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number).ptr;
  return std::string(buffer.data(), end);
}

/// The number written in the whole of the text, with nothing before or after; none if that is not so or it
/// does not fit the type. Accepts "nan" and "inf" for floating point; independent of the locale.
template <Number T>
std::optional<T> to_number(std::string_view text) {
  T number{};
  const char* const end = text.data() + text.size();
  const auto [stop, failure] = std::from_chars(text.data(), end, number);
  if (failure != std::errc() || stop != end) return std::nullopt;
  return number;
}

}  // namespace jampack
