// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <iostream>
#include <jampack/core/array.hpp>
#include <jampack/core/error.hpp>
#include <jampack/io/json.hpp>
#include <jampack/io/number.hpp>
#include <jampack/io/option_range.hpp>
#include <string>
#include <string_view>
#include <utility>

namespace jampack {

/// The options of a program. Each is declared with the variable it sets, whose value is the default:
///
///   Index grains = 100;
///   line.option("grains", grains, at_least(1), "number of grains");
///   if (!line.parse()) return;   // --help was asked for, and answered
///
/// parse() refuses, with InvalidInput and a message that names the option: unknown and repeated options,
/// missing values, text where a number belongs, NaN, infinity, numbers out of range, stray arguments.
class CommandLine {
 public:
  CommandLine(std::string program, std::string purpose, Array<std::string> arguments)
      : program_(std::move(program)), purpose_(std::move(purpose)), arguments_(std::move(arguments)) {}

  template <Number T>
  void option(std::string name, T& variable, OptionRange range, std::string help) {
    declare({.name = name,
             .kind = "N",
             .help = help + " (" + range.text() + "; " + to_text(variable) + ")",
             .set =
                 [name, &variable, range](const std::string& text) {
                   const auto number = to_number<T>(text);
                   require(number.has_value(), "--" + name + " must be " +
                                                   (std::integral<T> ? "a whole number" : "a number") +
                                                   ", not '" + text + "'");
                   require(range.contains(*number),
                           "--" + name + " must be " + range.text() + ", not " + text);
                   variable = *number;
                 },
             .value = [&variable] { return Json(variable); }});
  }

  /// A free text; an empty one is refused.
  void option(std::string name, std::string& variable, std::string help) {
    const std::string standard = variable.empty() ? "" : " (" + variable + ")";
    declare({.name = name,
             .kind = "TEXT",
             .help = help + standard,
             .set =
                 [name, &variable](const std::string& text) {
                   require(!text.empty(), "--" + name + " must not be empty");
                   variable = text;
                 },
             .value = [&variable] { return Json(variable); }});
  }

  /// One of the given words.
  void option(std::string name, std::string& variable, Array<std::string> words, std::string help) {
    std::string all;
    for (const std::string& word : words) all += (all.empty() ? "" : ", ") + word;
    declare({.name = name,
             .kind = "NAME",
             .help = help + " (" + all + "; " + variable + ")",
             .set =
                 [name, &variable, words, all](const std::string& text) {
                   bool known = false;
                   for (const std::string& word : words) known = known || word == text;
                   require(known, "--" + name + " must be one of " + all + ", not '" + text + "'");
                   variable = text;
                 },
             .value = [&variable] { return Json(variable); }});
  }

  /// An option without a value.
  void flag(std::string name, bool& variable, std::string help) {
    declare({.name = name,
             .kind = "",
             .help = std::move(help),
             .set = [&variable](const std::string&) { variable = true; },
             .value = [&variable] { return Json(variable); }});
  }

  /// An argument without a name, required, such as a file; in the order of declaration.
  void argument(std::string name, std::string& variable, std::string help) {
    positional_.push_back({.name = name,
                           .kind = "",
                           .help = std::move(help),
                           .set = [&variable](const std::string& text) { variable = text; },
                           .value = [&variable] { return Json(variable); }});
  }

  /// Sets the variables; false if --help was asked for, which is then printed to `out` and nothing is set.
  [[nodiscard]] bool parse(std::ostream& out = std::cout) {
    for (const std::string& argument : arguments_)
      if (argument == "--help" || argument == "-h") {
        out << help();
        return false;
      }
    Index n_positional = 0;
    for (Index i = 0; i < arguments_.size(); ++i) {
      const std::string& argument = arguments_[i];
      if (!argument.starts_with("--")) {
        require(n_positional < positional_.size() && !argument.starts_with("-"),
                "unexpected argument '" + argument + "'; see --help");
        positional_[n_positional++].set(argument);
        continue;
      }
      const auto equals = argument.find('=');
      Entry& entry = find(argument.substr(2, equals == std::string::npos ? equals : equals - 2));
      require(!entry.given, "--" + entry.name + " is given twice");
      entry.given = true;
      const bool is_flag = entry.kind.empty();
      require(!is_flag || equals == std::string::npos, "--" + entry.name + " takes no value");
      if (is_flag) {
        entry.set("");
      } else if (equals != std::string::npos) {
        entry.set(argument.substr(equals + 1));
      } else {
        require(i + 1 < arguments_.size() && !arguments_[i + 1].starts_with("--"),
                "--" + entry.name + " needs a value");
        entry.set(arguments_[++i]);
      }
    }
    require(
        n_positional == positional_.size(),
        n_positional == positional_.size() ? "" : positional_[n_positional].name + " is missing; see --help");
    return true;
  }

  /// Whether the option was given, for defaults that depend on other options.
  bool given(std::string_view name) { return find(std::string(name)).given; }

  /// All options with the values they have now, for the summary of a run.
  Json parameters() const {
    Json all = Json::object();
    for (const Entry& entry : positional_) all[entry.name] = entry.value();
    for (const Entry& entry : options_) all[entry.name] = entry.value();
    return all;
  }

  const std::string& program() const { return program_; }

  std::string help() const {
    std::string text = program_ + " " + purpose_ + "\n\nusage: " + program_;
    for (const Entry& entry : positional_) text += " " + entry.name;
    text += " [options]\n";
    for (const Entry& entry : positional_) text += help_line(entry.name, entry.help);
    for (const Entry& entry : options_)
      text += help_line("--" + entry.name + (entry.kind.empty() ? "" : " " + entry.kind), entry.help);
    return text + help_line("--help", "shows this");
  }

 private:
  struct Entry {
    std::string name;
    std::string kind;  ///< what stands for the value in the help; empty: takes none
    std::string help;
    std::function<void(const std::string&)> set;
    std::function<Json()> value;
    bool given = false;
  };

  static std::string help_line(std::string left, const std::string& right) {
    left.resize(left.size() < 24 ? 24 : left.size() + 1, ' ');
    return "  " + left + right + "\n";
  }

  void declare(Entry entry) { options_.push_back(std::move(entry)); }

  Entry& find(const std::string& name) {
    for (Entry& entry : options_)
      if (entry.name == name) return entry;
    throw InvalidInput("unknown option --" + name + "; see --help");
  }

  std::string program_;
  std::string purpose_;
  Array<std::string> arguments_;
  Array<Entry> options_;
  Array<Entry> positional_;
};

}  // namespace jampack
