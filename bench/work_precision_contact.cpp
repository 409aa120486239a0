// SPDX-License-Identifier: MIT
// Error of contact forces against CPU time: contact discretisation x element x cells, each with the mesh in
// random orientations, through the library's own steps:
// - plates: one sphere between two. The reference is the converged force of sphere_compression_reference.hpp;
// - column: two spheres between two plates. Where they meet is a mirror, so that each is one sphere between
//   plates and the force between them has the same reference (friction keeps them from turning and carries
//   nothing): a grain touches a grain;
// - cube: one sphere in a closing cube, to a packing fraction of 0.97; disk: one disk between two plates, to
//   half its diameter. Their references are fine meshes of two elements, extrapolated.
#include <Eigen/Geometry>
#include <algorithm>
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
#include <jampack/mesh/disk_mesh.hpp>
#include <jampack/packing/random.hpp>
#include <jampack/stepping/soft_step.hpp>
#include <sstream>

#include "measure.hpp"

using namespace jampack;
using jampack_bench::named;

namespace {

constexpr double friction = 0.3;  ///< between grains; walls have none

/// Unit balls in a room that closes by 1 - 2 delta at an approach delta of each contact.
template <int Dim>
struct Scene {
  std::string name;
  Container<Dim> room;
  Array<Vector<Dim>> centres;
  Array<double> approaches;  ///< over the diameter, at which forces are compared
  /// Of a step: long makes inertia nothing beside the force, short keeps grains from turning and the column,
  /// which is unstable, from falling before it is set upright again.
  double duration = 100;
};

Scene<3> plates_scene() {
  return {"plates", plates<3>(1.0), {Vector<3>::Zero()}, {0.02, 0.05, 0.075, 0.10, 0.20}};
}
Scene<3> column_scene() {
  return {
      "column", plates<3>(2.0), {Vector<3>(0, 0, -0.5), Vector<3>(0, 0, 0.5)}, {0.02, 0.05, 0.075, 0.10}, 2};
}
Scene<3> cube_scene() {
  const Vector<3> corner = Vector<3>::Constant(0.5);
  return {"cube", container(Box<3>{-corner, corner}), {Vector<3>::Zero()}, {0.02, 0.05, 0.075, 0.094}};
}
Scene<2> disk_scene() {
  return {"disk", plates<2>(1.0), {Vector<2>::Zero()}, {0.02, 0.05, 0.10, 0.25}};
}

struct Options {
  Index orientations = 20, seed = 7, reference_cells = 0;
  double poisson = 0.495;
  std::string scenes = "plates,column", contacts = "sampled,weighted",
              elements = "linear,macro,quadratic,resisting", cells = "400,816", out = ".";

  NeoHookean rubber() const { return {.young = 1, .poisson = poisson}; }
};

/// A column falls over: turns both grains together, which changes nothing between them, until the line of
/// their centres is the axis again.
template <class Packing>
void set_upright(Packing& packing) {
  if constexpr (Packing::dimension == 3) {
    auto &low = packing.grains[0], &high = packing.grains[1];
    const Vector<3> axis = high.centre() - low.centre(), middle = (high.centre() + low.centre()) / 2;
    const Matrix<3> turn = Eigen::Quaterniond::FromTwoVectors(axis, Vector<3>::UnitZ()).toRotationMatrix();
    for (auto* grain : {&low, &high})
      grain->position =
          ((turn * (grain->position.colwise() - middle)).colwise() + middle[2] * Vector<3>::UnitZ()).eval();
  }
}

/// Forces of one contact at the scene's approaches: the mean of the walls', or that between two balls.
template <int Dim, class Element, class Discretisation>
Array<double> press(const Mesh<Dim>& mesh, const Scene<Dim>& scene, const NeoHookean& material,
                    RandomSource& random) {
  using Packing = SoftPacking<Dim, Element, NeoHookean>;
  Packing packing(mesh, material, scene.room);
  for (const auto& centre : scene.centres)
    packing.add(1.0, centre, rotation_matrix<Dim>(random.orientation<Dim>()));
  SoftStep<Packing, SignoriniCoulomb, ProximalNewton, Discretisation> step(SignoriniCoulomb{friction}, {});
  const auto force = [&] {
    Vector<Dim> between = Vector<Dim>::Zero();
    for (Index c = 0; c < step.contacts.pairs.size(); ++c) {
      const bool up = step.contacts.pairs.contact[c].candidate == 0;
      between += (up ? 1.0 : -1.0) * step.contacts.pairs.force(c);
    }
    double on_walls = 0;
    for (const auto& r : step.contacts.walls.reaction) on_walls += r[0];
    return packing.grains.size() == 2 ? between.norm() : on_walls / double(packing.room.n_walls());
  };
  const auto advance = [&](double approach) {
    for (auto& grain : packing.grains) grain.velocity.setZero();
    const auto report = step.advance(packing, scene.duration, 1 - 2 * approach);
    if (packing.grains.size() == 2) set_upright(packing);
    return report;
  };
  Array<double> forces;
  double reached = 0;
  for (const double approach : scene.approaches) {
    for (double length = 0.01; reached < approach;) {
      const double next = approach - reached <= length * 1.001 ? approach : reached + length;
      const auto report = advance(next);
      if (report.converged) {
        reached = next;
        continue;
      }
      length *= 0.5;
      if (length < 1e-5) throw NotConverged(to_text(next) + ": " + report.reason);
    }
    // Until what inertia carried has gone.
    double before = force();
    for (int held = 0; held < 20; ++held) {
      if (const auto report = advance(reached); !report.converged)
        throw NotConverged("held at " + to_text(reached) + ": " + report.reason);
      const double now = force();
      if (std::abs(now - before) <= 1e-4 * now) break;
      before = now;
    }
    forces.push_back(force());
  }
  return forces;
}

/// Two fine meshes of macro elements, extrapolated at second order in the edge length, and the same of
/// quadratic ones: their difference says how far to trust the mean of both.
template <int Dim, class UnitMesh>
Array<double> extrapolated_reference(const Options& options, const Scene<Dim>& scene, Index cells,
                                     const UnitMesh& unit_mesh) {
  const Mesh<Dim> coarse = unit_mesh(cells / (Dim == 2 ? 4 : 2)), fine = unit_mesh(cells);
  const double gain = std::pow(double(fine.cells.size()) / double(coarse.cells.size()), 2.0 / Dim) - 1;
  std::cout << scene.name << ": forces with " << coarse.cells.size() << " and " << fine.cells.size()
            << " cells -> extrapolated, at the approaches in turn\n";
  const auto extrapolated = [&]<class Element>() {
    RandomSource random(3), same(3);
    const auto first = press<Dim, Element, SampledContact>(coarse, scene, options.rubber(), random);
    auto forces = press<Dim, Element, SampledContact>(fine, scene, options.rubber(), same);
    std::cout << std::setw(11) << Element::name;
    for (Index a = 0; a < forces.size(); ++a) {
      std::cout << "  " << first[a] << " " << forces[a];
      forces[a] += (forces[a] - first[a]) / gain;
      std::cout << " -> " << forces[a];
    }
    std::cout << std::endl;
    return forces;
  };
  auto mean = extrapolated.template operator()<MacroSimplex<Dim>>();
  const auto other = extrapolated.template operator()<QuadraticSimplex<Dim>>();
  std::cout << "the two differ by";
  for (Index a = 0; a < mean.size(); ++a) {
    std::cout << " " << 100 * (mean[a] / other[a] - 1) << " %";
    mean[a] = 0.5 * (mean[a] + other[a]);
  }
  std::cout << "; reference: their mean\n";
  return mean;
}

template <int Dim, class Element, class Discretisation>
void measure(const Options& options, const Scene<Dim>& scene, std::string_view contact, const Mesh<Dim>& mesh,
             const Array<double>& reference, CsvWriter& table) {
  if (!named(options.elements, Element::name) || !named(options.contacts, contact)) return;
  RandomSource random(static_cast<std::uint64_t>(options.seed));
  Array<double> mean(reference.size(), 0.0), worst(reference.size(), 0.0);
  Index n_done = 0;
  const double start = jampack_bench::cpu_seconds();
  for (Index o = 0; o < options.orientations; ++o) {
    try {
      const auto forces = press<Dim, Element, Discretisation>(mesh, scene, options.rubber(), random);
      for (Index a = 0; a < forces.size(); ++a) {
        const double error = forces[a] / reference[a] - 1;
        mean[a] += error;
        if (std::abs(error) > std::abs(worst[a])) worst[a] = error;
      }
      ++n_done;
    } catch (const NotConverged& failure) {
      std::cerr << scene.name << " " << Element::name << " " << contact << " " << o << ": " << failure.what()
                << "\n";
    }
  }
  const double seconds = (jampack_bench::cpu_seconds() - start) / double(options.orientations);
  std::cout << std::setw(8) << scene.name << std::setw(11) << Element::name << std::setw(10) << contact
            << std::setw(7) << mesh.cells.size() << std::setw(6) << mesh.nodes.size() << std::fixed
            << std::setprecision(1);
  for (Index a = 0; a < reference.size(); ++a) {
    mean[a] /= double(n_done);
    std::cout << std::setw(7) << 100 * mean[a] << " (" << std::setw(5) << 100 * worst[a] << ")";
    table.write({scene.name, options.poisson, Element::name, contact, mesh.cells.size(), mesh.nodes.size(),
                 scene.approaches[a], mean[a], worst[a], n_done, seconds, jampack_bench::compiler(),
                 jampack_bench::flags(), jampack_bench::commit()});
  }
  std::cout << std::setprecision(2) << std::setw(8) << seconds << " s  " << n_done << "/"
            << options.orientations << std::defaultfloat << std::endl;
}

/// All elements and discretisations asked for. Where there are no reference forces they are made here, with
/// as many cells as asked for or `fine_cells`.
template <int Dim, class UnitMesh>
void measure_scene(const Options& options, const Scene<Dim>& scene, Array<double> reference, Index fine_cells,
                   const UnitMesh& unit_mesh, CsvWriter& table) {
  if (!named(options.scenes, scene.name)) return;
  if (reference.empty())
    reference = extrapolated_reference(
        options, scene, options.reference_cells > 0 ? options.reference_cells : fine_cells, unit_mesh);
  std::cout << "force error in %, mean (worst), at delta/d =";
  for (const double approach : scene.approaches) std::cout << " " << approach;
  std::cout << "; CPU seconds\n";
  std::stringstream rest(options.cells);
  for (std::string word; std::getline(rest, word, ',');) {
    const auto wanted = to_number<Index>(word);
    require(wanted && *wanted > 0, "'" + word + "' is no number of cells");
    const Mesh<Dim> mesh = unit_mesh(*wanted);
    const auto both = [&]<class Element>() {
      measure<Dim, Element, SampledContact>(options, scene, "sampled", mesh, reference, table);
      if constexpr (Dim == 3)
        measure<Dim, Element, WeightedContact>(options, scene, "weighted", mesh, reference, table);
    };
    both.template operator()<LinearSimplex<Dim>>();
    both.template operator()<MacroSimplex<Dim>>();
    both.template operator()<QuadraticSimplex<Dim>>();
    both.template operator()<ResistingSimplex<Dim>>();
  }
}

void work_precision(CommandLine& line) {
  Options options;
  line.option("orientations", options.orientations, at_least(1), "random orientations of the mesh");
  line.option("seed", options.seed, at_least(0), "of the orientations");
  line.option("poisson", options.poisson, strictly_between(-1, 0.5),
              "Poisson's ratio; plates and column have a reference for 0.495 and 0.3");
  line.option("scenes", options.scenes, "plates, column, cube, disk");
  line.option("contacts", options.contacts, "sampled, weighted (spheres)");
  line.option("elements", options.elements, "linear, macro, quadratic, resisting");
  line.option("cells", options.cells, "wanted numbers of linear cells, separated by commas");
  line.option("reference-cells", options.reference_cells, at_least(0),
              "of the finer reference mesh, 0: 6656 in the cube, 6144 of the disk");
  line.option("out", options.out, "folder for work_precision_contact.csv");
  if (!line.parse()) return;
  make_output_folder(options.out);
  CsvWriter table(std::filesystem::path(options.out) / "work_precision_contact.csv",
                  {"scene", "poisson", "element", "contact", "cells", "nodes", "delta_over_d", "mean_error",
                   "worst_error", "n_orientations", "cpu_seconds", "compiler", "flags", "commit"});
  const auto ball = [](Index wanted) { return ball_mesh(wanted); };
  for (const auto& scene : {plates_scene(), column_scene()}) {
    Array<double> reference;
    for (const double approach : scene.approaches) {
      const auto force = sphere_compression_force({1, 1, options.poisson}, approach);
      require(force.has_value(), "plates and column have a reference for Poisson's ratios 0.495 and 0.3");
      reference.push_back(*force);
    }
    measure_scene(options, scene, reference, 0, ball, table);
  }
  measure_scene(options, cube_scene(), {}, 6656, ball, table);
  measure_scene(
      options, disk_scene(), {}, 6144, [](Index wanted) { return disk_mesh(wanted); }, table);
}

}  // namespace

int main(int argc, char** argv) {
  return run_program(argc, argv, "measures the error of contact discretisations against CPU time",
                     work_precision);
}
