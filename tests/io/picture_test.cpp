// SPDX-License-Identifier: MIT
#include <cstdint>
#include <jampack/io/curve_picture.hpp>
#include <jampack/io/surface_picture.hpp>
#include <limits>
#include <random>

#include "../catch.hpp"
#include "temporary_folder.hpp"

using namespace jampack;
using Catch::Matchers::WithinAbs;
using jampack_tests::contains;
using jampack_tests::TemporaryFolder;

namespace {

/// Undoes Deflate with fixed codes, straight from RFC 1951.
class Inflate {
 public:
  explicit Inflate(std::string data) : data_(std::move(data)) {}
  std::string text() {
    static constexpr int length_base[] = {3,  4,  5,  6,  7,  8,  9,  10, 11,  13,  15,  17,  19,  23, 27,
                                          31, 35, 43, 51, 59, 67, 83, 99, 115, 131, 163, 195, 227, 258};
    static constexpr int length_extra[] = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2,
                                           2, 3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 0};
    static constexpr int distance_base[] = {1,    2,    3,    4,    5,    7,    9,    13,    17,    25,
                                            33,   49,   65,   97,   129,  193,  257,  385,   513,   769,
                                            1025, 1537, 2049, 3073, 4097, 6145, 8193, 12289, 16385, 24577};
    REQUIRE(bits(1) == 1);
    REQUIRE(bits(2) == 1);
    std::string out;
    for (;;) {
      const int symbol = read_symbol();
      if (symbol == 256) return out;
      if (symbol < 256) {
        out += static_cast<char>(symbol);
        continue;
      }
      const int length = length_base[symbol - 257] + bits(length_extra[symbol - 257]);
      int slot = 0;
      for (int i = 0; i < 5; ++i) slot = 2 * slot + bits(1);
      const int distance = distance_base[slot] + bits(slot < 4 ? 0 : slot / 2 - 1);
      REQUIRE(distance <= static_cast<int>(out.size()));
      for (int i = 0; i < length; ++i) out += out[out.size() - static_cast<std::size_t>(distance)];
    }
  }

 private:
  int bits(int count) {
    int value = 0;
    for (int i = 0; i < count; ++i, ++position_)
      value |= (static_cast<unsigned char>(data_.at(position_ / 8)) >> (position_ % 8) & 1) << i;
    return value;
  }
  int read_symbol() {
    int code = 0;
    for (int i = 0; i < 7; ++i) code = 2 * code + bits(1);
    if (code < 0x18) return 256 + code;
    code = 2 * code + bits(1);
    if (code >= 0x30 && code < 0xC0) return code - 0x30;
    if (code >= 0xC0 && code < 0xC8) return 280 + code - 0xC0;
    return 144 + 2 * code + bits(1) - 0x190;
  }
  std::string data_;
  std::size_t position_ = 0;
};

Rgb centre(const Image& image) {
  return image.pixels[(image.height / 2) * image.width + image.width / 2];
}

ColouredSurface::Triangle facing_triangle(double z, double value) {
  return {{Vector<3>(-1, -1, z), Vector<3>(1, -1, z), Vector<3>(0, 1.5, z)}, {value, value, value}};
}

}  // namespace

TEST_CASE("compressed data are what an independent reading of the format gives back") {
  std::mt19937 random(1);
  for (const int alphabet : {1, 2, 5, 256})
    for (const int size : {0, 1, 2, 3, 10, 259, 100000}) {
      std::string data;
      for (int i = 0; i < size; ++i) data += static_cast<char>(random() % static_cast<unsigned>(alphabet));
      CHECK(Inflate(detail::Deflate::compress(data)).text() == data);
    }
  std::string far_repeats;
  for (int i = 0; i < 1750; ++i) far_repeats += static_cast<char>(random());
  for (int i = 0; i < 39; ++i) far_repeats += far_repeats.substr(0, 1750);
  const std::string compressed = detail::Deflate::compress(far_repeats);
  CHECK(Inflate(compressed).text() == far_repeats);
  CHECK(compressed.size() < far_repeats.size() / 10);
}

TEST_CASE("a PNG begins, sizes and ends as it must; an empty one is refused") {
  const TemporaryFolder folder;
  write_png(folder / "a.png", Image{3, 2, Array<Rgb>(6, Rgb{1, 2, 3})});
  const std::string file = read_file(folder / "a.png");
  CHECK(file.starts_with(std::string("\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR\0\0\0\3\0\0\0\2", 24)));
  CHECK(file.ends_with(std::string("\0\0\0\0IEND\xae\x42\x60\x82", 12)));  // its published checksum
  CHECK_THROWS_AS(write_png(folder / "b.png", Image{}), InvalidInput);
  CHECK_THROWS_AS(write_png(folder / "b.png", Image{2, 2, Array<Rgb>(3)}), InvalidInput);
}

TEST_CASE("the nearer triangle hides the farther, in either order of drawing") {
  for (const bool near_first : {false, true}) {
    ColouredSurface surface = ColouredSurface::of_dimension<2>();
    surface.width = 100;
    surface.triangles = {facing_triangle(near_first ? 1 : 0, near_first ? 1 : 0),
                         facing_triangle(near_first ? 0 : 1, near_first ? 0 : 1)};
    const Rgb yellow = centre(render(surface));
    CHECK(yellow[0] > 230);
    CHECK(yellow[2] < 60);
  }
}

TEST_CASE("corner values are interpolated and the range of colours can be set") {
  ColouredSurface surface = ColouredSurface::of_dimension<2>();
  surface.width = 200;
  surface.add_triangle<2>({Vector<2>(0, 0), Vector<2>(1, 0), Vector<2>(0.5, 1)}, {0, 2, 1});
  const Rgb middle = centre(render(surface));
  const Vector<3> expected = 255 * viridis(0.5);
  for (int c = 0; c < 3; ++c) CHECK_THAT(middle[static_cast<std::size_t>(c)], WithinAbs(expected[c], 2.0));

  CHECK(surface.value_range() == std::pair(0.0, 2.0));
  surface.upper = 1;
  CHECK(surface.value_range() == std::pair(0.0, 1.0));
  CHECK(centre(render(surface))[0] > 230);
}

TEST_CASE("a lit triangle seen from the side of the light is brighter than one seen from behind") {
  const auto brightness = [](bool towards) {
    ColouredSurface surface;
    surface.width = 60;
    surface.towards_viewer = Vector<3>::UnitZ();
    surface.up = Vector<3>::UnitY();
    surface.triangles = {facing_triangle(0, 1)};
    surface.lower = 0;
    if (!towards) std::swap(surface.triangles[0].corner[0], surface.triangles[0].corner[1]);
    return centre(render(surface))[1];
  };
  CHECK(brightness(true) > brightness(false) + 50);
}

TEST_CASE("corners shared at a small angle are rounded, edges of a cube are not") {
  using Triangle = ColouredSurface::Triangle;
  const auto normal_at_shared_corner = [](double rise) {
    const Vector<3> a(0, 0, 0), b(0, 1, 0);
    const Array<Triangle> pair{Triangle{{a, Vector<3>(1, 0, -rise), b}, {}},
                               Triangle{{a, b, Vector<3>(-1, 0, -rise)}, {}}};
    return detail::corner_normals(pair)[0][0];
  };
  CHECK_THAT(normal_at_shared_corner(0.2)[0], WithinAbs(0, 1e-12));
  CHECK_THAT(normal_at_shared_corner(2.0)[0], WithinAbs(2 / std::sqrt(5.0), 1e-12));
}

TEST_CASE("what cannot be drawn is refused") {
  ColouredSurface surface;
  CHECK_THROWS_WITH(render(surface), contains("no triangles"));
  surface.triangles = {facing_triangle(std::numeric_limits<double>::quiet_NaN(), 0)};
  CHECK_THROWS_WITH(render(surface), contains("not finite"));
  surface.triangles = {{{Vector<3>::Zero(), Vector<3>::Zero(), Vector<3>::Zero()}, {}}};
  CHECK_THROWS_WITH(render(surface), contains("in one point"));
  surface.triangles = {facing_triangle(0, 0)};
  surface.up = surface.towards_viewer;
  CHECK_THROWS_WITH(render(surface), contains("direction of view"));
}

TEST_CASE("a picture is written with or without gnuplot, and nothing else is left") {
  const TemporaryFolder folder;
  ColouredSurface surface;
  surface.width = 80;
  surface.triangles = {facing_triangle(0, std::numeric_limits<double>::quiet_NaN()), facing_triangle(1, 1)};
  surface.add_box<3>(Vector<3>(-1, -1, 0), Vector<3>(1, 1, 1));
  CHECK(surface.lines.size() == 12);
  draw(surface, "von Mises stress / E*, it's", folder / "it's a packing.png");
  CHECK(read_file(folder / "it's a packing.png").starts_with("\x89PNG"));
  Index n_files = 0;
  for ([[maybe_unused]] const auto& file : std::filesystem::directory_iterator(folder.path)) ++n_files;
  CHECK(n_files == 1);
}

TEST_CASE("a curve picture is made where gnuplot is, and its script stays") {
  const TemporaryFolder folder;
  write_file(folder / "curve.csv", "phi,P_over_Estar\n0.5,0\n0.6,0.1\n0.7,\n0.8,0.5\n");
  const CurvePicture picture{.x_label = "phi",
                             .y_label = "P/E*",
                             .curves = {{"curve.csv", "phi", "P_over_Estar", "measured", true},
                                        {"curve.csv", "phi", "P_over_Estar", "law_with_underscores", false}}};
  const bool made = draw(picture, folder / "curve.png");
  CHECK(std::filesystem::exists(folder / "curve.gp"));
  CHECK(made == std::filesystem::exists(folder / "curve.png"));
  if (std::system("gnuplot --version >/dev/null 2>&1") == 0) {
    CHECK(made);
    CHECK(read_file(folder / "curve.png").starts_with("\x89PNG"));
  }
  CHECK_THROWS_AS(draw(CurvePicture{}, folder / "none.png"), InvalidInput);
}
