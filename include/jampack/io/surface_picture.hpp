// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <jampack/core/array.hpp>
#include <jampack/io/colour_map.hpp>
#include <jampack/io/coloured_surface.hpp>
#include <jampack/io/file.hpp>
#include <jampack/io/gnuplot.hpp>
#include <jampack/io/number.hpp>
#include <jampack/io/png.hpp>
#include <jampack/io/surface_renderer.hpp>
#include <string>
#include <system_error>

namespace jampack {

/// Draws coloured surfaces to a PNG file. Where gnuplot is installed a colour bar with this label is set
/// beside them; without it the picture is the same but for the bar. Throws InvalidInput where there is
/// nothing to draw, Error where the file cannot be written.
inline void draw(const ColouredSurface& surface, const std::string& label, const std::filesystem::path& png) {
  const Image image = render(surface);
  write_png(png, image);

  std::string palette;
  for (const auto& [red, green, blue] : viridis_points)
    palette += (palette.empty() ? "" : ", ") + std::to_string(palette.size()) + " " + to_text(red) + " " +
               to_text(green) + " " + to_text(blue);
  const auto [lower, upper] = surface.value_range();
  const Index bar_width = 190;
  const std::string name = png.filename().string();
  std::filesystem::path script = png;
  script += ".gp";
  std::filesystem::path framed = png;
  framed += ".framed";
  write_file(
      script,
      "set terminal pngcairo size " + std::to_string(image.width + bar_width) + "," +
          std::to_string(image.height) + " fontscale 1.5\nset output " + gnuplot_quoted(name + ".framed") +
          "\nunset key\nunset border\nunset tics\nset lmargin at screen 0\nset bmargin at screen 0\n" +
          "set tmargin at screen 1\nset rmargin at screen " +
          to_text(static_cast<double>(image.width) / static_cast<double>(image.width + bar_width)) +
          "\nset xrange [0:" + std::to_string(image.width) +
          "]\nset yrange [0:" + std::to_string(image.height) + "]\nset palette defined (" + palette +
          ")\nset cbrange [" + to_text(lower) + ":" + to_text(upper > lower ? upper : lower + 1) +
          "]\nset colorbox user size 0.02,0.6 " + "origin " +
          to_text((static_cast<double>(image.width) + 10.0) / static_cast<double>(image.width + bar_width)) +
          ",0.2\nset cbtics\nset cblabel " + gnuplot_quoted(label) + " noenhanced\nplot " +
          gnuplot_quoted(name) + " binary filetype=png with rgbimage, NaN with points palette\n");
  std::error_code failure;
  if (run_gnuplot(script) && std::filesystem::file_size(framed, failure) > 0)
    std::filesystem::rename(framed, png, failure);
  std::filesystem::remove(framed, failure);
  std::filesystem::remove(script, failure);
}

}  // namespace jampack
