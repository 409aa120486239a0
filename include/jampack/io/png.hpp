// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <jampack/core/array.hpp>
#include <jampack/core/error.hpp>
#include <jampack/io/file.hpp>
#include <string>
#include <string_view>

namespace jampack {

/// Red, green, blue.
using Rgb = std::array<std::uint8_t, 3>;

/// Pixels row by row, the top one first.
struct Image {
  Index width = 0;
  Index height = 0;
  Array<Rgb> pixels;
};

namespace detail {

/// Deflate (RFC 1951) with the fixed codes and the latest match only: a third of the best ratio for a
/// hundredth of the code.
class Deflate {
 public:
  static std::string compress(std::string_view data) {
    Deflate deflate;
    deflate.bits(0b011, 3);  // the last block, fixed codes
    constexpr Index table_size = 1 << 15;
    Array<Index> latest(table_size, -1);
    const auto at = [&](Index i) { return static_cast<std::uint8_t>(data[static_cast<std::size_t>(i)]); };
    const auto n = static_cast<Index>(data.size());
    const auto key = [&](Index i) {
      return (at(i) * 5003 + at(i + 1) * 131 + at(i + 2) * 7919) % table_size;
    };
    for (Index i = 0; i < n;) {
      Index length = 0, match = -1;
      if (i + 3 <= n) {
        match = latest[key(i)];
        if (match >= 0 && i - match <= 32768)
          while (length < 258 && i + length < n && at(match + length) == at(i + length)) ++length;
      }
      if (length < 3) length = 1;
      if (length == 1)
        deflate.symbol(at(i));
      else
        deflate.pair(static_cast<int>(length), static_cast<int>(i - match));
      for (const Index end = i + length; i < end; ++i)
        if (i + 3 <= n) latest[key(i)] = i;
    }
    deflate.symbol(256);
    deflate.bits(0, 7);  // fills the last byte
    return deflate.bytes_;
  }

 private:
  void bits(std::uint32_t value, int count) {  // least significant first
    for (int bit = 0; bit < count; ++bit) {
      buffer_ |= ((value >> bit) & 1U) << n_buffered_;
      if (++n_buffered_ == 8) {
        bytes_ += static_cast<char>(buffer_);
        buffer_ = 0;
        n_buffered_ = 0;
      }
    }
  }
  void code(std::uint32_t value, int count) {  // most significant first
    for (int bit = count - 1; bit >= 0; --bit) bits((value >> bit) & 1U, 1);
  }
  void symbol(int s) {
    const auto u = static_cast<std::uint32_t>(s);
    if (s < 144)
      code(0x30 + u, 8);
    else if (s < 256)
      code(0x190 + u - 144, 9);
    else if (s < 280)
      code(u - 256, 7);
    else
      code(0xC0 + u - 280, 8);
  }
  void pair(int length, int distance) {
    // Codes come in groups of 4 (lengths) and 2 (distances), whose bases and widths double (3.2.5).
    int slot = 0, base = 3, extra = 0;
    if (length == 258) {
      symbol(285);
    } else {
      while (length >= base + (1 << extra)) {
        base += 1 << extra;
        if (++slot >= 8 && slot % 4 == 0) ++extra;
      }
      symbol(257 + slot);
      bits(static_cast<std::uint32_t>(length - base), extra);
    }
    slot = 0, base = 1, extra = 0;
    while (distance >= base + (1 << extra)) {
      base += 1 << extra;
      if (++slot >= 4 && slot % 2 == 0) ++extra;
    }
    code(static_cast<std::uint32_t>(slot), 5);
    bits(static_cast<std::uint32_t>(distance - base), extra);
  }

  std::string bytes_;
  std::uint32_t buffer_ = 0;
  int n_buffered_ = 0;
};

inline std::string big_endian(std::uint32_t number) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>((number >> shift) & 255U);
  return bytes;
}

inline std::string png_chunk(const std::string& type_and_data) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const char character : type_and_data) {
    crc ^= static_cast<std::uint8_t>(character);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
  }
  return big_endian(static_cast<std::uint32_t>(type_and_data.size() - 4)) + type_and_data + big_endian(~crc);
}

}  // namespace detail

/// Writes a PNG file (true colour, 8 bits a channel). Throws InvalidInput for an image without pixels or with
/// the wrong number of them.
inline void write_png(const std::filesystem::path& path, const Image& image) {
  require(image.width > 0 && image.height > 0 && image.pixels.size() == image.width * image.height,
          path.string() + ": the image has no pixels, or not width * height of them");
  std::string raw;  // each row as differences to its left neighbours (filter type 1)
  for (Index row = 0; row < image.height; ++row) {
    raw += '\1';
    Rgb left{0, 0, 0};
    for (Index column = 0; column < image.width; ++column) {
      const Rgb& pixel = image.pixels[row * image.width + column];
      for (std::size_t c = 0; c < 3; ++c) raw += static_cast<char>(pixel[c] - left[c]);
      left = pixel;
    }
  }
  std::uint32_t a = 1, b = 0;  // Adler-32
  for (const char character : raw) {
    a = (a + static_cast<std::uint8_t>(character)) % 65521;
    b = (b + a) % 65521;
  }
  using detail::big_endian;
  using detail::png_chunk;
  const std::string header = big_endian(static_cast<std::uint32_t>(image.width)) +
                             big_endian(static_cast<std::uint32_t>(image.height)) +
                             std::string("\x08\x02\x00\x00\x00", 5);
  write_file(path, "\x89PNG\r\n\x1a\n" + png_chunk("IHDR" + header) +
                       png_chunk("IDAT\x78\x01" + detail::Deflate::compress(raw) + big_endian(b << 16 | a)) +
                       png_chunk("IEND"));
}

}  // namespace jampack
