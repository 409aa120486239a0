// SPDX-License-Identifier: MIT
// Error of contact forces against CPU time: contact discretisation x element x cells, each with the mesh in
// random orientations, through the library's own steps, nu = 0.495:
// - plates: one sphere between two; the reference is the converged force of sphere_compression_reference.hpp;
// - two: spheres in a box of one by one by two diameters that closes. By symmetry each is one sphere in a
// cube
//   (where they meet is a mirror, so that friction between them keeps them from turning and carries nothing):
//   the reference is that sphere, finely meshed. Here a grain touches a grain, and that force is compared.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <jampack/analysis/sphere_compression_reference.hpp>
#include <jampack/detection/weighted_contact.hpp>
#include <jampack/element/linear_simplex.hpp>
#include <jampack/element/macro_simplex.hpp>
#include <jampack/element/quadratic_simplex.hpp>
#include <jampack/io/command_line.hpp>
#include <jampack/io/csv_writer.hpp>
#include <jampack/io/run_program.hpp>
#include <jampack/law/signorini_coulomb.hpp>
#include <jampack/material/neo_hookean.hpp>
#include <jampack/mesh/ball_mesh.hpp>
#include <jampack/packing/random.hpp>
#include <jampack/stepping/soft_step.hpp>
#include <sstream>

#include "measure.hpp"

using namespace jampack;

namespace {

/// Approaches at one contact over the diameter at which forces are compared; a cube is full soon after 0.085.
using Approaches = std::array<double, 4>;
constexpr Approaches between_plates{0.02, 0.05, 0.075, 0.10}, in_cube{0.02, 0.05, 0.075, 0.085};
using Forces = std::array<double, 4>;  ///< of one contact, at these

constexpr NeoHookean rubber{.young = 1, .poisson = 0.495};
constexpr double friction = 0.3;  ///< between grains; walls have none

struct Options {
  Index orientations = 20, reference_cells = 6600;
  std::string scenes = "plates,two", contacts = "sampled,weighted", elements = "linear,macro,quadratic",
              cells = "400,816", out = ".";
};

bool named(const std::string& list, std::string_view name) {
  return ("," + list + ",").find("," + std::string(name) + ",") != std::string::npos;
}

enum class Scene { plates, cube, two };

/// Presses spheres of unit diameter that touch; the mean force of a wall, or that between two spheres.
template <class Element, class Discretisation>
Forces press(const Mesh<3>& mesh, Scene scene, RandomSource& random) {
  using Packing = SoftPacking<3, Element, NeoHookean>;
  const Index n = scene == Scene::two ? 2 : 1;
  const Vector<3> corner(0.5, 0.5, 0.5 * double(n));
  Packing packing(mesh, rubber, scene == Scene::plates ? plates<3>(1.0) : container(Box<3>{-corner, corner}));
  for (Index i = 0; i < n; ++i)
    packing.add(1.0, Vector<3>(0, 0, 0.5 - corner[2] + double(i)),
                rotation_matrix<3>(random.orientation<3>()));
  const Approaches& approaches = scene == Scene::plates ? between_plates : in_cube;
  SoftStep<Packing, SignoriniCoulomb, ProximalNewton, Discretisation> step(SignoriniCoulomb{friction}, {});
  Forces forces{};
  double reached = 0;
  for (std::size_t a = 0; a < approaches.size(); ++a) {
    for (double length = 0.01; reached < approaches[a];) {
      const double next = approaches[a] - reached <= length * 1.001 ? approaches[a] : reached + length;
      // As slow as makes inertia nothing beside the force, and as fast as keeps grains from turning.
      const double slow = 100;
      for (auto& grain : packing.grains) grain.velocity.setZero();
      const auto report = step.advance(packing, slow, 1 - 2 * next);
      if (report.converged) {
        reached = next;
        continue;
      }
      length *= 0.5;
      if (length < 1e-5) throw NotConverged(to_text(next) + ": " + report.reason);
    }
    Vector<3> between = Vector<3>::Zero();
    for (Index c = 0; c < step.contacts.pairs.size(); ++c) {
      const bool up = step.contacts.pairs.contact[c].candidate == 0;
      between += (up ? 1.0 : -1.0) * step.contacts.pairs.force(c);
    }
    double on_walls = 0;
    for (const auto& r : step.contacts.walls.reaction) on_walls += r[0];
    forces[a] = n == 2 ? between.norm() : on_walls / double(packing.room.n_walls());
  }
  return forces;
}

/// Of one sphere in a cube: two fine meshes of quadratic elements, extrapolated at second order in the edge
/// length, and the same of macro elements: their difference says how far to trust the mean of both.
Forces cube_reference(const Options& options) {
  const Mesh<3> coarse = ball_mesh(options.reference_cells / 2), fine = ball_mesh(options.reference_cells);
  const double gain = std::pow(double(fine.cells.size()) / double(coarse.cells.size()), 2.0 / 3) - 1;
  const auto extrapolated = [&]<class Element>() {
    RandomSource random(3), same(3);
    const Forces first = press<Element, WeightedContact>(coarse, Scene::cube, random);
    Forces forces = press<Element, WeightedContact>(fine, Scene::cube, same);
    std::cout << std::setw(11) << Element::name;
    for (std::size_t a = 0; a < in_cube.size(); ++a) {
      std::cout << "  " << first[a] << " " << forces[a];
      forces[a] += (forces[a] - first[a]) / gain;
      std::cout << " -> " << forces[a];
    }
    std::cout << std::endl;
    return forces;
  };
  std::cout << "one sphere in a cube, " << coarse.cells.size() << " and " << fine.cells.size()
            << " cells -> extrapolated: force at delta/d = 0.02, 0.05, 0.075, 0.085\n";
  const Forces macro = extrapolated.template operator()<MacroSimplex<3>>();
  const Forces quadratic = extrapolated.template operator()<QuadraticSimplex<3>>();
  Forces mean{};
  std::cout << "the two differ by";
  for (std::size_t a = 0; a < in_cube.size(); ++a) {
    mean[a] = 0.5 * (macro[a] + quadratic[a]);
    std::cout << " " << 100 * (macro[a] / quadratic[a] - 1) << " %";
  }
  std::cout << "; reference: their mean\n";
  return mean;
}

template <class Element, class Discretisation>
void measure(const Options& options, const std::string& scene, std::string_view contact, const Mesh<3>& mesh,
             const Forces& reference, CsvWriter& table) {
  if (!named(options.elements, Element::name) || !named(options.contacts, contact)) return;
  const bool with_two = scene == "two";
  const Approaches& approaches = with_two ? in_cube : between_plates;
  RandomSource random(7);
  Forces mean{}, worst{};
  Index n_done = 0;
  const double start = jampack_bench::cpu_seconds();
  for (Index o = 0; o < options.orientations; ++o) {
    try {
      const Forces forces =
          press<Element, Discretisation>(mesh, with_two ? Scene::two : Scene::plates, random);
      for (std::size_t a = 0; a < approaches.size(); ++a) {
        const double error = forces[a] / reference[a] - 1;
        mean[a] += error;
        if (std::abs(error) > std::abs(worst[a])) worst[a] = error;
      }
      ++n_done;
    } catch (const NotConverged& failure) {
      std::cerr << scene << " " << Element::name << " " << contact << " " << o << ": " << failure.what()
                << "\n";
    }
  }
  const double seconds = (jampack_bench::cpu_seconds() - start) / double(options.orientations);
  std::cout << std::setw(8) << scene << std::setw(11) << Element::name << std::setw(10) << contact
            << std::setw(7) << mesh.cells.size() << std::setw(6) << mesh.nodes.size() << std::fixed
            << std::setprecision(1);
  for (std::size_t a = 0; a < approaches.size(); ++a) {
    mean[a] /= double(n_done);
    std::cout << std::setw(7) << 100 * mean[a] << " (" << std::setw(5) << 100 * worst[a] << ")";
    table.write({scene, Element::name, contact, mesh.cells.size(), mesh.nodes.size(), approaches[a], mean[a],
                 worst[a], n_done, seconds, jampack_bench::compiler(), jampack_bench::flags(),
                 jampack_bench::commit()});
  }
  std::cout << std::setprecision(2) << std::setw(8) << seconds << " s  " << n_done << "/"
            << options.orientations << std::defaultfloat << std::endl;
}

void work_precision(CommandLine& line) {
  Options options;
  line.option("orientations", options.orientations, at_least(1), "random orientations of the mesh");
  line.option("scenes", options.scenes, "plates, two");
  line.option("contacts", options.contacts, "sampled, weighted");
  line.option("elements", options.elements, "linear, macro, quadratic");
  line.option("cells", options.cells, "wanted numbers of linear cells, separated by commas");
  line.option("reference-cells", options.reference_cells, at_least(64), "of the one sphere in a cube");
  line.option("out", options.out, "folder for work_precision_contact.csv");
  if (!line.parse()) return;
  make_output_folder(options.out);
  CsvWriter table(std::filesystem::path(options.out) / "work_precision_contact.csv",
                  {"scene", "element", "contact", "cells", "nodes", "delta_over_d", "mean_error",
                   "worst_error", "n_orientations", "cpu_seconds", "compiler", "flags", "commit"});
  for (const std::string scene : {"plates", "two"}) {
    if (!named(options.scenes, scene)) continue;
    Forces reference{};
    if (scene == "two") {
      reference = cube_reference(options);
    } else {
      for (std::size_t a = 0; a < between_plates.size(); ++a)
        reference[a] = *sphere_compression_force({1, 1, rubber.poisson}, between_plates[a]);
    }
    std::cout << "force error in %, mean (worst), at delta/d = 0.02, 0.05, 0.075, "
              << (scene == "two" ? "0.085" : "0.10") << "; CPU seconds\n";
    std::stringstream rest(options.cells);
    for (std::string word; std::getline(rest, word, ',');) {
      const auto wanted = to_number<Index>(word);
      require(wanted && *wanted > 0, "'" + word + "' is no number of cells");
      const Mesh<3> mesh = ball_mesh(*wanted);
      const auto both = [&]<class Element>() {
        measure<Element, SampledContact>(options, scene, "sampled", mesh, reference, table);
        measure<Element, WeightedContact>(options, scene, "weighted", mesh, reference, table);
      };
      both.template operator()<LinearSimplex<3>>();
      both.template operator()<MacroSimplex<3>>();
      both.template operator()<QuadraticSimplex<3>>();
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  return run_program(argc, argv, "measures the error of contact discretisations against CPU time",
                     work_precision);
}
