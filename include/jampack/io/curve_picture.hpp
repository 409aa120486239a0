// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <jampack/core/array.hpp>
#include <jampack/core/error.hpp>
#include <jampack/io/file.hpp>
#include <jampack/io/gnuplot.hpp>
#include <string>

namespace jampack {

/// Curves from the columns of CSV files: measured ones as points, laws as lines over them.
struct CurvePicture {
  struct Curve {
    std::string csv;       ///< file name in the picture's own folder
    std::string x_column;  ///< as named in the first line of the file
    std::string y_column;
    std::string title;
    bool as_points = false;
  };

  std::string x_label;
  std::string y_label;
  Array<Curve> curves;
  bool logarithmic_y = false;
  std::string key = "left top";  ///< where the titles stand, as gnuplot has it
};

/// Writes the gnuplot script beside the picture (x.png: x.gp, to be edited and run again) and runs it.
/// Returns whether the picture was made: false where gnuplot is not installed. Throws InvalidInput for no
/// curves, Error where the script cannot be written.
inline bool draw(const CurvePicture& picture, const std::filesystem::path& png) {
  require(!picture.curves.empty(), png.string() + ": no curves to draw");
  const auto enhanced_off = [](const std::string& text) { return gnuplot_quoted(text) + " noenhanced"; };
  std::string script = "set terminal pngcairo size 1200,900 fontscale 1.4 linewidth 1.6\nset output " +
                       gnuplot_quoted(png.filename().string()) +
                       "\nset datafile separator comma\nset datafile missing ''\nset key " + picture.key +
                       " Left reverse\n"
                       "set grid lc rgb '#dddddd'\nset border 3\nset tics nomirror out\n";
  script +=
      "set xlabel " + enhanced_off(picture.x_label) + "\nset ylabel " + enhanced_off(picture.y_label) + "\n";
  if (picture.logarithmic_y) script += "set logscale y\nset format y '10^{%T}'\n";
  script += "colours = '#d95f02 #1b9e77 #7570b3 #e7298a #66a61e #e6ab02 #444444'\n";
  std::string plot = "plot ";
  for (Index i = 0; i < picture.curves.size(); ++i) {
    const CurvePicture::Curve& curve = picture.curves[i];
    const std::string colour = " lc rgb word(colours, " + std::to_string(1 + (i + 6) % 7) + ")";
    plot += (i > 0 ? ", \\\n     " : "") + gnuplot_quoted(curve.csv) + " using (column(" +
            gnuplot_quoted(curve.x_column) + ")):(column(" + gnuplot_quoted(curve.y_column) + ")) with " +
            (curve.as_points ? "points pt 6 ps 1.1" : "lines lw 2") + colour + " title " +
            enhanced_off(curve.title);
  }
  std::filesystem::path path = png;
  path.replace_extension(".gp");
  write_file(path, script + plot + "\n");
  return run_gnuplot(path);
}

}  // namespace jampack
