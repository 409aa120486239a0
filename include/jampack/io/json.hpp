// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <concepts>
#include <jampack/core/array.hpp>
#include <jampack/io/number.hpp>
#include <ranges>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>

namespace jampack {

/// A JSON value to be written (RFC 8259): members keep the order in which they were set, numbers read back
/// exactly, and NaN and infinity, which JSON does not have, become null.
///
///   Json summary;
///   summary["phi"] = 0.91;
///   summary["timings"]["seconds"] = 12.5;
class Json {
 public:
  Json() = default;  ///< null
  Json(bool value) : value_(value) {}
  Json(std::string_view text) : value_(std::string(text)) {}
  Json(const char* text) : value_(std::string(text)) {}
  Json(const std::string& text) : value_(text) {}
  template <Number T>
  Json(T number) {
    if constexpr (std::floating_point<T>) {
      if (std::isfinite(number)) value_ = Literal{to_text(number)};
    } else {
      value_ = Literal{to_text(number)};
    }
  }
  /// An array of whatever can be a JSON value.
  template <std::ranges::input_range Range>
  requires(!std::convertible_to<Range, std::string_view> && !std::same_as<std::remove_cvref_t<Range>, Json>)
      Json(const Range& range)
      : value_(Elements()) {
    for (const auto& element : range) push_back(Json(element));
  }

  static Json object() {
    Json json;
    json.value_ = Members();
    return json;
  }
  static Json array() {
    Json json;
    json.value_ = Elements();
    return json;
  }

  /// The member of this name, appended as null where there is none; makes an object of a null.
  Json& operator[](std::string_view name) {
    if (std::holds_alternative<std::monostate>(value_)) value_ = Members();
    auto& members = std::get<Members>(value_);
    for (auto& [key, value] : members)
      if (key == name) return value;
    return members.emplace_back(std::string(name), Json()).second;
  }

  /// Appends to an array; makes one of a null.
  void push_back(Json element) {
    if (std::holds_alternative<std::monostate>(value_)) value_ = Elements();
    std::get<Elements>(value_).push_back(std::move(element));
  }

  /// Indented text, without a line end after the last brace.
  std::string text(int indentation = 0) const {
    if (const auto* truth = std::get_if<bool>(&value_)) return *truth ? "true" : "false";
    if (const auto* number = std::get_if<Literal>(&value_)) return number->text;
    if (const auto* text = std::get_if<std::string>(&value_)) return quoted(*text);
    if (const auto* elements = std::get_if<Elements>(&value_)) {
      std::string inside;
      for (const Json& element : *elements)
        inside += (inside.empty() ? "" : ", ") + element.text(indentation + 2);
      return "[" + inside + "]";
    }
    if (const auto* members = std::get_if<Members>(&value_)) {
      const std::string space(static_cast<std::size_t>(indentation + 2), ' ');
      std::string inside;
      for (const auto& [key, value] : *members)
        inside += (inside.empty() ? "\n" : ",\n") + space + quoted(key) + ": " + value.text(indentation + 2);
      if (inside.empty()) return "{}";
      return "{" + inside + "\n" + space.substr(2) + "}";
    }
    return "null";
  }

 private:
  struct Literal {
    std::string text;
  };
  using Elements = Array<Json>;
  using Members = Array<std::pair<std::string, Json>>;

  static std::string quoted(std::string_view text) {
    static constexpr char digit[] = "0123456789abcdef";
    std::string result = "\"";
    for (const char character : text) {
      const auto code = static_cast<unsigned char>(character);
      if (character == '"' || character == '\\') {
        result += '\\';
        result += character;
      } else if (character == '\n') {
        result += "\\n";
      } else if (character == '\t') {
        result += "\\t";
      } else if (code < 0x20) {
        result += "\\u00";
        result += digit[code >> 4];
        result += digit[code & 15];
      } else {
        result += character;
      }
    }
    return result + "\"";
  }

  std::variant<std::monostate, bool, Literal, std::string, Elements, Members> value_;
};

}  // namespace jampack
