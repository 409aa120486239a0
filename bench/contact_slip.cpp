// SPDX-License-Identifier: MIT
// Partial slip in plane strain, elements x contact discretisations x meshes, against Cattaneo's and Mindlin's
// closed forms: half-width of contact and of its part that sticks, forces along the contact, hysteresis loop.
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <jampack/detection/weighted_contact.hpp>
#include <jampack/io/command_line.hpp>
#include <jampack/io/csv_writer.hpp>
#include <jampack/io/run_program.hpp>
#include <sstream>

#include "../tests/stepping/pressed_blocks.hpp"
#include "measure.hpp"

using namespace jampack;

namespace {

struct Options {
  std::string sizes = "12,24", out = ".";
  double approach = 0.0035, radius = 4;
};

template <class Element, class Discretisation>
void measure(std::string_view contact, Index n, const Options& options, CsvWriter& table) {
  const double start = jampack_bench::cpu_seconds();
  std::cout << std::setw(10) << Element::name << std::setw(10) << contact << std::setw(5) << n << std::fixed
            << std::setprecision(1);
  try {
    const auto figures = jampack_tests::measure_slip<Element, Discretisation>(
        n, options.radius, options.approach, 5, {0.1, 0.25, 0.5, 0.75, 0.9}, 18);
    const double seconds = jampack_bench::cpu_seconds() - start;
    for (const double figure :
         {figures.half_width_error, figures.pressure_error, figures.traction_error, figures.stick_error,
          figures.spacing, figures.loop_error, figures.closing_error})
      std::cout << std::setw(8) << 100 * figure;
    std::cout << std::setw(8) << seconds << " s" << std::endl;
    table.write({Element::name, contact, n, figures.half_width, figures.normal_force,
                 figures.half_width_error, figures.pressure_error, figures.traction_error,
                 figures.stick_error, figures.spacing, figures.loop_error, figures.closing_error, seconds,
                 jampack_bench::compiler(), jampack_bench::flags(), jampack_bench::commit()});
  } catch (const NotConverged& failure) {
    std::cout << "  " << failure.what() << std::endl;
  }
}

void slip(CommandLine& line) {
  Options options;
  line.option("sizes", options.sizes, "meshes of 2 x 2n x n macros, separated by commas");
  line.option("approach", options.approach, strictly_between(0, 0.05), "of each plate over the block's side");
  line.option("radius", options.radius, at_least(0.6), "of the round faces over the block's side");
  line.option("out", options.out, "folder for contact_slip.csv");
  if (!line.parse()) return;
  make_output_folder(options.out);
  CsvWriter table(std::filesystem::path(options.out) / "contact_slip.csv",
                  {"element", "contact", "n", "half_width", "normal_force", "half_width_error",
                   "pressure_error", "traction_error", "stick_error", "spacing", "loop_error",
                   "closing_error", "cpu_seconds", "compiler", "flags", "commit"});
  std::cout
      << "all in %: half-width, pressure, traction, c/a, spacing of nodes there, loop, its closing; CPU s\n";
  std::stringstream rest(options.sizes);
  for (std::string word; std::getline(rest, word, ',');) {
    const auto n = to_number<Index>(word);
    require(n && *n > 0, "'" + word + "' is no number of macros");
    const auto both = [&]<class Element>() {
      measure<Element, SampledContact>("sampled", *n, options, table);
      measure<Element, WeightedContact>("weighted", *n, options, table);
    };
    both.template operator()<MacroSimplex<2>>();
    both.template operator()<QuadraticSimplex<2>>();
  }
}

}  // namespace

int main(int argc, char** argv) {
  return run_program(argc, argv, "measures partial slip against closed forms", slip);
}
