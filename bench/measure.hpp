// SPDX-License-Identifier: MIT
#pragma once

#include <ctime>
#include <string>
#include <string_view>

namespace jampack_bench {

/// CPU seconds of this process: what a shared machine disturbs least.
inline double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

/// Whether a list separated by commas has this name; an empty one has all.
inline bool named(const std::string& list, std::string_view name) {
  return list.empty() || ("," + list + ",").find("," + std::string(name) + ",") != std::string::npos;
}

/// CPU seconds of one run of work(), repeated until `least` seconds have passed.
template <class Work>
double seconds_of(Work&& work, double least = 0.2) {
  const double start = cpu_seconds();
  int n = 0;
  do {
    work();
    ++n;
  } while (cpu_seconds() - start < least);
  return (cpu_seconds() - start) / n;
}

/// Compiler, its flags and the commit, for the rows of a CSV file.
inline std::string compiler() {
#ifdef __clang__
  return "clang " __clang_version__;
#else
  return "g++ " __VERSION__;
#endif
}
inline std::string flags() {
#ifdef JAMPACK_BENCH_FLAGS
  return JAMPACK_BENCH_FLAGS;
#else
  return "";
#endif
}
inline std::string commit() {
#ifdef JAMPACK_BENCH_COMMIT
  return JAMPACK_BENCH_COMMIT;
#else
  return "";
#endif
}

}  // namespace jampack_bench
