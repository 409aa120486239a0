// SPDX-License-Identifier: MIT
// Contact by contact, the normal force between FEM grains beside Hertz's law: a packing without friction is
// jammed, meshed and pressed through a sequence of room sizes, and balls under HertzCheck go through the same
// sizes from the same places. An FEM force is compared with Hertz's at the FEM grains' own centres (the
// deviation of the law) and with the force of the same contact between the balls (that of the model: its
// centres and its network as well). One sphere between six walls, finely meshed, goes through the same sizes:
// the other contacts of a grain press it as well, which Hertz's law does not know.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <jampack/analysis/ball_network.hpp>
#include <jampack/analysis/contact_approach.hpp>
#include <jampack/analysis/contact_counterparts.hpp>
#include <jampack/analysis/hertz.hpp>
#include <jampack/analysis/power_law_fit.hpp>
#include <jampack/analysis/sphere_compression_reference.hpp>
#include <jampack/element/macro_simplex.hpp>
#include <jampack/io/command_line.hpp>
#include <jampack/io/csv_writer.hpp>
#include <jampack/io/curve_picture.hpp>
#include <jampack/io/run_program.hpp>
#include <jampack/law/signorini.hpp>
#include <jampack/material/neo_hookean.hpp>
#include <jampack/mesh/ball_mesh.hpp>
#include <jampack/packing/handover.hpp>
#include <jampack/stepping/hertz_balance.hpp>
#include <jampack/stepping/jam.hpp>
#include <jampack/stepping/press_to.hpp>
#include <limits>

#include "measure.hpp"

using namespace jampack;

namespace {

using SoftGrains = SoftPacking<3, MacroSimplex<3>, NeoHookean>;
using SoftRun = Compaction<SoftGrains, Signorini>;

constexpr NeoHookean rubber{.young = 1, .poisson = 0.495};
constexpr HertzCheck law{.young = rubber.young, .poisson = rubber.poisson};
constexpr double preparation_stress = 1e-5;  // over E: delta/d is below 0.001 then
/// Without friction grains hardly held take many steps to settle; deviations are tens of percent.
const CompactionOptions pressing{.settled = 5e-3, .max_settling_steps = 15};
constexpr double none = std::numeric_limits<double>::quiet_NaN();

struct Options {
  Index grains = 20, cells = 800, lattice_cells = 3000, seed = 1, packings = 1, records = 10, threads = 1;
  double first = 0.005, strain = 0.12, least = 0.002, resolved = 0.02;
  std::string out = ".";
};

/// One contact of FEM grains beside Hertz's law.
struct Comparison {
  Index seed;
  double strain;  ///< 1 - size of the room over its size under the preparation stress
  ContactForce<3> contact;
  double delta_over_d;  ///< approach_over_diameter of the FEM grains
  double force;         ///< normal
  double hertz_force;   ///< Hertz's at the FEM grains' centres
  double balls_force;   ///< normal force of the same contact of the balls; NaN where they do not touch

  double root() const { return std::sqrt(delta_over_d); }
  double own_ratio() const { return force / hertz_force; }
  double balls_ratio() const { return force / balls_force; }
};

HertzContact hertz_contact(const ContactNetwork<3>& network, const ContactForce<3>& contact) {
  const auto sphere = [&](Index grain) {
    return HertzSphere{network.diameters[grain], rubber.young, rubber.poisson};
  };
  return contact.at_wall() ? hertz_sphere_on_plane(sphere(contact.candidate))
                           : hertz_two_spheres(sphere(contact.candidate), sphere(contact.antagonist));
}

/// Closes the room until it has this scale, and lets the grains settle.
void press_to_scale(SoftRun& run, double scale) {
  for (double left; (left = 3 * std::log(run.packing.room.scale / scale)) > 1e-9;) {
    const double wise = std::min(run.strain, run.options.max_strain);
    run.advance(left / std::ceil(left / wise));
  }
  if (!run.settle()) std::cout << "  not settled: see the imbalance\n";
}

/// The contacts of FEM grains that carry something and are pressed by `least` of their diameter at least.
Array<Comparison> compare(Index seed, double strain, const ContactNetwork<3>& soft,
                          const ContactNetwork<3>& balls, double least) {
  const double counts = contact_threshold(soft);
  const auto counterparts = contact_counterparts(soft, balls);
  Array<Comparison> comparisons;
  for (Index c = 0; c < soft.contacts.size(); ++c) {
    const auto& contact = soft.contacts[c];
    const double delta_over_d = approach_over_diameter(soft, contact), force = normal_force(contact);
    if (force <= counts || delta_over_d < least) continue;
    const double hertz = hertz_contact(soft, contact).force(contact_approach(soft, contact));
    const Index other = counterparts[c];
    const double of_balls = other < 0 ? none : normal_force(balls.contacts[other]);
    comparisons.push_back({seed, strain, contact, delta_over_d, force, hertz, of_balls});
  }
  return comparisons;
}

void print_networks(double strain, const SoftRun& run, const ContactNetwork<3>& soft,
                    const ContactNetwork<3>& balls) {
  const auto counterparts = contact_counterparts(soft, balls);
  const auto common = std::count_if(counterparts.begin(), counterparts.end(), [](Index c) { return c >= 0; });
  std::cout << std::fixed << std::setprecision(4) << std::setw(8) << strain << std::setw(9)
            << run.packing_fraction() << std::scientific << std::setprecision(3) << std::setw(12)
            << granular_pressure(soft) << std::setw(12) << granular_pressure(balls) << std::setw(7)
            << soft.contacts.size() << std::setw(7) << balls.contacts.size() << std::setw(7) << common
            << std::setw(12) << grain_imbalance(soft) << std::fixed << std::setprecision(1) << std::setw(9)
            << jampack_bench::cpu_seconds() << std::endl;
}

/// Presses one packing through all sizes, until a step fails. `report` gets what each size gives.
template <class Report>
void press_packing(const Options& options, Index n_grains, Index seed, const Mesh<3>& mesh, Report&& report) {
  const auto loose = random_packing<3>({.n_grains = n_grains, .seed = static_cast<std::uint64_t>(seed)});
  const auto jammed = jam(loose, Signorini{}, {.stress = preparation_stress});
  SoftStepOptions step_options;
  step_options.threads.count = static_cast<int>(options.threads);
  SoftRun run(meshed_grains<MacroSimplex>(jammed.packing, mesh, rubber), Signorini{}, pressing, step_options);
  Balls<3> balls = jammed.packing.balls;
  for (Index g = 0; g < balls.size(); ++g) balls.position[g] = run.packing.grains[g].centre();

  std::cout << "grains " << n_grains << ", cells " << mesh.cells.size() << ", seed " << seed
            << "\n  strain      phi       P FEM     P balls   FEM  balls   both"
            << "   imbalance    CPU s\n";
  try {
    press_to(run, {.stress = preparation_stress});
    const double start = run.packing.room.scale;
    for (Index record = 0; record < options.records; ++record) {
      const double strain =
          options.first * std::pow(options.strain / options.first,
                                   double(record) / double(std::max<Index>(options.records - 1, 1)));
      press_to_scale(run, (1 - strain) * start);
      const auto balanced = balance(balls, run.packing.room, law);
      const auto soft = run.network();
      const auto hertz_balls = contact_network(balls, run.packing.room.volume(), balanced.forces);
      print_networks(strain, run, soft, hertz_balls);
      report(compare(seed, strain, soft, hertz_balls, options.least));
    }
  } catch (const NotConverged& failure) {
    std::cout << "  stopped: " << failure.what() << std::endl;
  }
}

/// A CSV file of contacts, one a row.
class ContactTable {
 public:
  explicit ContactTable(const std::filesystem::path& file)
      : table_(file, {"seed", "strain", "grain", "other_grain", "wall", "delta_over_d", "root_delta_over_d",
                      "fem_force", "hertz_force", "ratio", "balls_force", "ratio_to_balls", "compiler",
                      "flags", "commit"}) {}

  void write(const Comparison& c) {
    table_.write({c.seed, c.strain, c.contact.candidate, c.contact.antagonist, c.contact.wall, c.delta_over_d,
                  c.root(), c.force, c.hertz_force, c.own_ratio(), c.balls_force, c.balls_ratio(),
                  jampack_bench::compiler(), jampack_bench::flags(), jampack_bench::commit()});
  }

 private:
  CsvWriter table_;
};

/// Value below which this fraction of the sample lies, by linear interpolation; NaN for no sample.
double quantile(Array<double> sample, double fraction) {
  if (sample.empty()) return none;
  std::sort(sample.begin(), sample.end());
  const double place = fraction * double(sample.size() - 1);
  const auto below = static_cast<Index>(place);
  const Index above = std::min(below + 1, sample.size() - 1);
  return std::lerp(sample[below], sample[above], place - double(below));
}

/// The part of the contacts that a column of the table looks at, and the ratio it shows.
struct Column {
  bool at_wall;
  double (Comparison::*ratio)() const;
};
constexpr std::array<Column, 4> columns{{{false, &Comparison::own_ratio},
                                         {true, &Comparison::own_ratio},
                                         {false, &Comparison::balls_ratio},
                                         {true, &Comparison::balls_ratio}}};

/// What a column shows of the contacts whose sqrt(delta/d) is in [lower, upper).
struct Sample {
  Array<double> root, ratio;
};
Sample sample(const Array<Comparison>& comparisons, const Column& column, double lower, double upper) {
  Sample chosen;
  for (const Comparison& c : comparisons) {
    const double ratio = (c.*column.ratio)();
    if (c.contact.at_wall() != column.at_wall || c.root() < lower || c.root() >= upper || std::isnan(ratio))
      continue;
    chosen.root.push_back(c.root());
    chosen.ratio.push_back(ratio);
  }
  return chosen;
}

void print_quartiles(const Array<double>& ratio) {
  if (ratio.empty())
    std::cout << std::setw(25) << "-";
  else
    std::cout << std::setw(6) << ratio.size() << std::setw(6) << quantile(ratio, 0.5) << " (" << std::setw(4)
              << quantile(ratio, 0.25) << ", " << std::setw(4) << quantile(ratio, 0.75) << ")";
}

void print_bins(const Array<Comparison>& comparisons, const Array<Comparison>& lattice) {
  std::cout
      << "\nF / F_Hertz, number of contacts, median (quartiles); plates: one sphere between two, converged\n"
      << std::setw(14) << "sqrt(delta/d)" << std::setw(8) << "plates";
  for (const char* title :
       {"lattice", "own centres, grains", "own centres, walls", "to balls, grains", "to balls, walls"})
    std::cout << std::setw(25) << title;
  double largest = 0;
  for (const Comparison& c : comparisons) largest = std::max(largest, c.root());
  constexpr double width = 0.05;
  for (double lower = 0; lower <= largest; lower += width) {
    const double middle = lower + 0.5 * width;
    std::cout << std::fixed << std::setprecision(2) << "\n"
              << std::setw(7) << lower << " -" << std::setw(5) << lower + width << std::setw(8)
              << sphere_compression_ratio(middle * middle, rubber.poisson).value_or(none);
    print_quartiles(sample(lattice, {true, &Comparison::own_ratio}, lower, lower + width).ratio);
    for (const Column& column : columns)
      print_quartiles(sample(comparisons, column, lower, lower + width).ratio);
  }
  std::cout << "\n";
}

/// c is fitted to the contacts that the mesh resolves.
void print_fits(const Array<Comparison>& comparisons, double resolved) {
  std::cout << "\nF / F_Hertz = 1 + c sqrt(delta/d), delta/d >= " << std::setprecision(3) << resolved << "\n";
  for (const Column& column : columns) {
    const bool own = column.ratio == &Comparison::own_ratio;
    std::cout << std::setw(16) << (own ? "own centres, " : "against balls, ") << std::setw(7)
              << (column.at_wall ? "walls" : "grains");
    try {
      const auto fitted =
          sample(comparisons, column, std::sqrt(resolved), std::numeric_limits<double>::infinity());
      Array<double> deviation;
      for (const double ratio : fitted.ratio) deviation.push_back(ratio - 1);
      const SlopeFit fit = slope_fit(fitted.root, deviation);
      std::cout << ": c = " << fit.slope.value << " +- " << fit.slope.standard_error << ", " << fit.n_points
                << " contacts\n";
    } catch (const InvalidInput& error) {
      std::cout << ": " << error.what() << "\n";
    }
  }
}

void draw_deviation(const std::filesystem::path& folder, const Array<Comparison>& comparisons) {
  double largest = 0;
  for (const Comparison& c : comparisons) largest = std::max(largest, c.root());
  CsvWriter table(folder / "hertz_plates.csv", {"root_delta_over_d", "ratio"});
  const Index n = 100;
  for (Index i = 0; i <= n; ++i) {
    const double root = largest * double(i) / double(n);
    table.write({root, sphere_compression_ratio(root * root, rubber.poisson).value_or(none)});
  }
  CurvePicture picture;
  picture.x_label = "sqrt(delta / d)";
  picture.y_label = "FEM force / Hertz's at the same centres";
  picture.curves = {
      {"hertz_contacts_grains.csv", "root_delta_over_d", "ratio", "two grains of a packing", true},
      {"hertz_contacts_walls.csv", "root_delta_over_d", "ratio", "grain and wall", true},
      {"hertz_contacts_lattice.csv", "root_delta_over_d", "ratio", "one sphere between six walls", true},
      {"hertz_plates.csv", "root_delta_over_d", "ratio", "one sphere between two plates, converged"}};
  draw(picture, folder / "hertz_contacts.png");
}

void hertz_contacts(CommandLine& line) {
  Options options;
  line.option("grains", options.grains, at_least(2), "number of grains");
  line.option("cells", options.cells, at_least(32), "linear elements a grain, nearest there is");
  line.option("lattice-cells", options.lattice_cells, at_least(32),
              "elements of the one sphere between six walls (a simple cubic lattice) beside the packing");
  line.option("seed", options.seed, at_least(0), "of the first random packing");
  line.option("packings", options.packings, at_least(1), "packings, of seeds one after the other");
  line.option("records", options.records, at_least(1), "sizes of the room at which forces are compared");
  line.option("first", options.first, strictly_between(0, 0.3), "first linear strain of the room");
  line.option("strain", options.strain, strictly_between(0, 0.3), "last one");
  line.option("least", options.least, above(0), "least delta/d of a contact that is compared");
  line.option("resolved", options.resolved, above(0), "delta/d from which the mesh resolves a contact");
  line.option("threads", options.threads, from_to(1, 4096), "threads");
  line.option("out", options.out, "folder for hertz_contacts_*.csv and hertz_contacts.png");
  if (!line.parse()) return;
  make_output_folder(options.out);
  const std::filesystem::path folder = options.out;
  const Mesh<3> mesh = ball_mesh(options.cells);
  ContactTable of_grains(folder / "hertz_contacts_grains.csv"), of_walls(folder / "hertz_contacts_walls.csv"),
      of_lattice(folder / "hertz_contacts_lattice.csv");
  Array<Comparison> lattice, comparisons;
  press_packing(options, 1, options.seed, ball_mesh(options.lattice_cells), [&](const auto& compared) {
    for (const Comparison& comparison : compared) {
      of_lattice.write(comparison);
      lattice.push_back(comparison);
    }
  });
  for (Index k = 0; k < options.packings; ++k)
    press_packing(options, options.grains, options.seed + k, mesh, [&](const auto& compared) {
      for (const Comparison& comparison : compared) {
        (comparison.contact.at_wall() ? of_walls : of_grains).write(comparison);
        comparisons.push_back(comparison);
      }
    });
  print_bins(comparisons, lattice);
  print_fits(comparisons, options.resolved);
  draw_deviation(folder, comparisons);
}

}  // namespace

int main(int argc, char** argv) {
  return run_program(argc, argv, "compares the forces between FEM grains with Hertz's, contact by contact",
                     hertz_contacts);
}
