// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <bit>
#include <concepts>
#include <cstdint>
#include <jampack/core/array.hpp>
#include <jampack/core/error.hpp>
#include <map>
#include <string>
#include <string_view>

namespace jampack {

/// Appends values to a byte string: integers as 8 bytes and doubles as their bits, both little endian,
/// whatever the machine; sequences as their length and their entries.
class CheckpointWriter {
 public:
  std::string bytes;

  void operator()(std::uint64_t number) {
    std::array<char, 8> little;
    for (std::size_t i = 0; i < 8; ++i) little[i] = static_cast<char>((number >> (8 * i)) & 0xff);
    bytes.append(little.data(), little.size());
  }
  void operator()(std::int64_t number) { (*this)(static_cast<std::uint64_t>(number)); }
  void operator()(double number) { (*this)(std::bit_cast<std::uint64_t>(number)); }
  void operator()(const std::string& text) {
    (*this)(static_cast<std::uint64_t>(text.size()));
    bytes += text;
  }
  template <int Rows, int Columns>
  void operator()(const Eigen::Matrix<double, Rows, Columns>& matrix) {
    if constexpr (Columns == Eigen::Dynamic) (*this)(std::int64_t(matrix.cols()));
    for (Index k = 0; k < matrix.size(); ++k) (*this)(matrix.data()[k]);
  }
  template <class T, std::size_t N>
  void operator()(const std::array<T, N>& values) {
    for (const T& value : values) (*this)(std::int64_t(value));
  }
  template <class T, class Each>
  void sequence(const Array<T>& values, Each each) {
    (*this)(std::int64_t(values.size()));
    for (const T& value : values) each(value);
  }
  void operator()(const std::map<std::string, std::string>& values) {
    (*this)(static_cast<std::uint64_t>(values.size()));
    for (const auto& [key, value] : values) {
      (*this)(key);
      (*this)(value);
    }
  }
};

/// Reads back what CheckpointWriter wrote, in the same order; throws InvalidInput at the end of the bytes.
class CheckpointReader {
 public:
  explicit CheckpointReader(std::string_view bytes) : rest_(bytes) {}

  void operator()(std::uint64_t& number) {
    const std::string_view little = take(8);
    number = 0;
    for (std::size_t i = 0; i < 8; ++i)
      number |= static_cast<std::uint64_t>(static_cast<unsigned char>(little[i])) << (8 * i);
  }
  void operator()(std::int64_t& number) {
    std::uint64_t bits = 0;
    (*this)(bits);
    number = static_cast<std::int64_t>(bits);
  }
  void operator()(double& number) {
    std::uint64_t bits = 0;
    (*this)(bits);
    number = std::bit_cast<double>(bits);
  }
  void operator()(std::string& text) { text = take(static_cast<std::size_t>(length(1))); }
  template <int Rows, int Columns>
  void operator()(Eigen::Matrix<double, Rows, Columns>& matrix) {
    if constexpr (Columns == Eigen::Dynamic) matrix.resize(Rows, length(8 * Rows));
    for (Index k = 0; k < matrix.size(); ++k) (*this)(matrix.data()[k]);
  }
  template <class T, std::size_t N>
  void operator()(std::array<T, N>& values) {
    for (T& value : values) {
      std::int64_t number = 0;
      (*this)(number);
      value = static_cast<T>(number);
    }
  }
  template <class T, class Each>
  void sequence(Array<T>& values, Each each) {
    values.resize(length(8));
    for (T& value : values) each(value);
  }
  void operator()(std::map<std::string, std::string>& values) {
    values.clear();
    for (Index n = length(16); n > 0; --n) {
      std::string key, value;
      (*this)(key);
      (*this)(value);
      values.emplace(std::move(key), std::move(value));
    }
  }
  bool at_end() const { return rest_.empty(); }

 private:
  std::string_view take(std::size_t n) {
    require(n <= rest_.size(), "its content ends early");
    const std::string_view taken = rest_.substr(0, n);
    rest_.remove_prefix(n);
    return taken;
  }
  /// A length whose entries, of at least `entry` bytes each, can still follow.
  Index length(std::size_t entry) {
    std::uint64_t n = 0;
    (*this)(n);
    require(n <= rest_.size() / entry, "a length in it is impossible");
    return static_cast<Index>(n);
  }

  std::string_view rest_;
};

/// Checksum of bytes: FNV-1a, 64 bits.
inline std::uint64_t checksum(std::string_view bytes) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char byte : bytes) hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3ULL;
  return hash;
}

}  // namespace jampack
