// SPDX-License-Identifier: MIT
// Error against CPU time for each finite element: a sphere between two frictionless plates in random
// orientations, against the finite-strain reference (docs/theory/compaction_laws.md), and Cook's membrane at
// nu = 0.4999, against the converged deflection. Contact is with plane walls alone, by an augmented
// Lagrangian of its own, so that the curves say something about elements and nothing about the library's
// contact step.
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <jampack/analysis/hertz.hpp>
#include <jampack/analysis/sphere_compression_reference.hpp>
#include <jampack/element/brick.hpp>
#include <jampack/element/composite_simplex.hpp>
#include <jampack/element/linear_simplex.hpp>
#include <jampack/element/macro_simplex.hpp>
#include <jampack/element/quadratic_simplex.hpp>
#include <jampack/geometry/face_shape.hpp>
#include <jampack/io/command_line.hpp>
#include <jampack/io/csv_writer.hpp>
#include <jampack/io/curve_picture.hpp>
#include <jampack/io/run_program.hpp>
#include <jampack/material/linear_elastic.hpp>
#include <jampack/material/neo_hookean.hpp>
#include <jampack/mesh/ball_mesh.hpp>
#include <jampack/mesh/brick_mesh.hpp>
#include <jampack/packing/random.hpp>
#include <map>
#include <sstream>

#include "measure.hpp"

using namespace jampack;
using jampack_bench::cpu_seconds;
using jampack_bench::named;

namespace {

/// One constraint on a plane wall: sum_i weight_i z_i <= h (upper) or >= -h (lower), weights sum to 1.
struct WallRow {
  std::vector<std::pair<Index, double>> entry;
  double area = 0;
};

/// Non-penetration at every boundary node.
Array<WallRow> node_rows(const Mesh<3>& mesh) {
  Array<WallRow> rows;
  for (const Index i : mesh.boundary_nodes) rows.push_back({{{i, 1.0}}, 0});
  return rows;
}

/// Non-penetration at the centres of the four parts of every quadratic face.
Array<WallRow> centre_rows(const Mesh<3>& mesh) {
  Array<WallRow> rows;
  constexpr double sixth = 1.0 / 6, third = 1.0 / 3;
  for (const auto& face : mesh.faces)
    for (const auto& [a, b] :
         {std::pair{sixth, sixth}, {4 * sixth, sixth}, {sixth, 4 * sixth}, {third, third}}) {
      const auto shape = face_shape<3>(face.n_nodes, FaceCoordinates<3>(a, b)).value;
      WallRow row;
      for (Index j = 0; j < face.n_nodes; ++j)
        row.entry.emplace_back(face.node[static_cast<std::size_t>(j)], shape[j]);
      rows.push_back(row);
    }
  return rows;
}

/// Gaps of the quadratic faces, weighted by the linear shape functions of their four parts: a row a node.
Array<WallRow> weighted_rows(const Mesh<3>& mesh) {
  std::map<Index, std::map<Index, double>> sums;
  constexpr std::array<std::array<std::size_t, 3>, 4> part{{{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}}};
  constexpr double near = 2.0 / 3, far = 1.0 / 6;  // three points, exact for quadratic integrands
  for (const auto& face : mesh.faces)
    for (const auto& corner : part) {
      const auto at = [&](std::size_t i) { return mesh.nodes[face.node[corner[i]]]; };
      const double area = (at(1) - at(0)).cross(at(2) - at(0)).norm() / 2;
      for (std::size_t q = 0; q < 3; ++q) {
        FaceCoordinates<3> xi = FaceCoordinates<3>::Zero();
        for (std::size_t i = 0; i < 3; ++i)
          xi += (i == q ? near : far) * face_node_coordinates<3>(static_cast<Index>(corner[i]));
        const auto shape = face_shape<3>(face.n_nodes, xi).value;
        for (std::size_t i = 0; i < 3; ++i)
          for (Index j = 0; j < face.n_nodes; ++j)
            sums[face.node[corner[i]]][face.node[static_cast<std::size_t>(j)]] +=
                area / 3 * (i == q ? near : far) * shape[j];
      }
    }
  Array<WallRow> rows;
  for (const auto& [node, sum] : sums) {
    WallRow row;
    for (const auto& [other, weight] : sum) row.area += weight;
    for (const auto& [other, weight] : sum) row.entry.emplace_back(other, weight / row.area);
    rows.push_back(row);
  }
  return rows;
}

const Array<std::string> contact_names = {"nodes", "centres", "samples", "weighted"};

/// The constraints of one kind of contact; "samples" are nodes and centres, what the library's step uses.
Array<WallRow> rows_of(const std::string& contact, const Mesh<3>& mesh) {
  if (contact == "nodes") return node_rows(mesh);
  if (contact == "weighted") return weighted_rows(mesh);
  Array<WallRow> rows = centre_rows(mesh);
  if (contact == "samples")
    for (const auto& row : node_rows(mesh)) rows.push_back(row);
  return rows;
}

/// One body: assembly into a sparse matrix of fixed pattern (its lower triangle), factorisation, Newton
/// steps.
template <int Dim, class Element, class Material>
struct Body {
  Mesh<Dim> mesh;
  Material material;
  Array<typename Element::Cell> cells;
  Eigen::VectorXd reference, volume, x, force;
  Eigen::SparseMatrix<double> tangent;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor;
  Array<int> position;  ///< of each cell's entries in `tangent`, -1 above the diagonal

  Body(const Mesh<Dim>& of, const Material& made_of, const Matrix<Dim>& rotation,
       const Array<WallRow>& rows = {})
      : mesh(of), material(made_of) {
    cells = Element::cells(mesh, 1.0, rotation);
    const Index n = mesh.nodes.size();
    reference.resize(Dim * n);
    for (Index i = 0; i < n; ++i) reference.template segment<Dim>(Dim * i) = rotation * mesh.nodes[i];
    x = reference;
    volume = Eigen::VectorXd::Zero(n);
    std::vector<Eigen::Triplet<double>> entries;
    const auto couple = [&](Index a, Index b) {
      for (int i = 0; i < Dim; ++i)
        for (int j = 0; j < Dim; ++j)
          if (Dim * a + i >= Dim * b + j)
            entries.emplace_back(static_cast<int>(Dim * a + i), static_cast<int>(Dim * b + j), 0.0);
    };
    for (const auto& cell : cells) {
      for (const Index a : cell.node)
        for (const Index b : cell.node) couple(a, b);
      typename Element::VolumeShares shares = Element::VolumeShares::Zero();
      Element::add_volume_shares(cell, shares);
      for (int a = 0; a < Element::n_nodes; ++a) volume[cell.node[static_cast<std::size_t>(a)]] += shares[a];
    }
    for (const auto& row : rows)
      for (const auto& [a, weight_a] : row.entry)
        for (const auto& [b, weight_b] : row.entry) couple(a, b);
    tangent.resize(Dim * n, Dim * n);
    tangent.setFromTriplets(entries.begin(), entries.end());
    for (const auto& cell : cells)
      for (int j = 0; j < Dim * Element::n_nodes; ++j)
        for (int i = 0; i < Dim * Element::n_nodes; ++i)
          position.push_back(find(Dim * cell.node[static_cast<std::size_t>(i / Dim)] + i % Dim,
                                  Dim * cell.node[static_cast<std::size_t>(j / Dim)] + j % Dim));
    factor.analyzePattern(tangent);
  }

  int find(Index row, Index column) const {
    if (row < column) return -1;
    const int* first = tangent.innerIndexPtr() + tangent.outerIndexPtr()[column];
    const int* last = tangent.innerIndexPtr() + tangent.outerIndexPtr()[column + 1];
    return static_cast<int>(std::lower_bound(first, last, static_cast<int>(row)) - tangent.innerIndexPtr());
  }

  typename Element::Nodal gather(const typename Element::Cell& cell, const Eigen::VectorXd& at) const {
    typename Element::Nodal nodal;
    for (int a = 0; a < Element::n_nodes; ++a)
      nodal.col(a) = at.template segment<Dim>(Dim * cell.node[static_cast<std::size_t>(a)]);
    return nodal;
  }

  bool assemble() {
    force = Eigen::VectorXd::Zero(x.size());
    tangent.coeffs().setZero();
    typename Element::Nodal f;
    typename Element::Tangent k;
    const int* to = position.data();
    for (const auto& cell : cells) {
      if (!Element::force_and_tangent(cell, material, gather(cell, x), f, k)) return false;
      for (int a = 0; a < Element::n_nodes; ++a)
        force.template segment<Dim>(Dim * cell.node[static_cast<std::size_t>(a)]) += f.col(a);
      for (int i = 0; i < k.size(); ++i, ++to)
        if (*to >= 0) tangent.valuePtr()[*to] += k.data()[i];
    }
    return true;
  }

  /// x - share * step, the largest share 1, 1/2, 1/4... that keeps a third of every cell's volume ratio.
  void move(const Eigen::VectorXd& step) {
    const auto admissible = [&](const Eigen::VectorXd& at) {
      for (const auto& cell : cells)
        if (!(Element::min_jacobian(cell, gather(cell, at)) >
              Element::min_jacobian(cell, gather(cell, x)) / 3))
          return false;
      return true;
    };
    for (double share = 1; share > 1e-6; share /= 2)
      if (const Eigen::VectorXd trial = x - share * step; admissible(trial)) {
        x = trial;
        return;
      }
    throw NotConverged("no admissible step");
  }
};

/// A ball of unit diameter and modulus between plates at z = +-h, held from sliding and turning on average.
template <class Element>
struct PressedBall : Body<3, Element, NeoHookean> {
  using Base = Body<3, Element, NeoHookean>;
  Array<WallRow> rows;
  std::array<Eigen::VectorXd, 2> multiplier;
  Eigen::Matrix<double, Eigen::Dynamic, 5> held;
  double moment = 0;  ///< of what holds it, over force times diameter
  Index n_factorisations = 0;

  PressedBall(const Mesh<3>& of, const Matrix<3>& rotation, const Array<WallRow>& wall_rows, double poisson)
      : Base(of, NeoHookean{1, poisson, 1}, rotation, wall_rows), rows(wall_rows) {
    multiplier.fill(Eigen::VectorXd::Zero(rows.size()));
    held.setZero(this->x.size(), 5);
    for (Index i = 0; i < of.nodes.size(); ++i) {
      const Vector<3> at = this->volume[i] * this->reference.template segment<3>(3 * i);
      held.template block<2, 2>(3 * i, 0) = this->volume[i] * Matrix<2>::Identity();
      held.template block<3, 3>(3 * i, 2) << 0, at[2], -at[1], -at[2], 0, at[0], at[1], -at[0], 0;
    }
  }

  /// Mean force of the plates in balance at z = +-h.
  double press(double h) {
    const double penalty = 200 * std::cbrt(1.0 / static_cast<double>(this->cells.size()));
    double deepest = 0;
    for (int update = 0; update < 40; ++update) {
      const double total = balance(h, penalty);
      deepest = 0;
      for (std::size_t side = 0; side < 2; ++side)
        for (Index r = 0; r < rows.size(); ++r) {
          const double gap = gap_of(r, side, h);
          deepest = std::max(deepest, -gap);
          multiplier[side][r] = std::max(0.0, multiplier[side][r] - penalty * gap);
        }
      if (deepest < 2e-5) return total;
    }
    throw NotConverged("plates: penetration " + to_text(deepest));
  }

 private:
  double gap_of(Index r, std::size_t side, double h) const {
    double z = 0;
    for (const auto& [node, weight] : rows[r].entry) z += weight * this->x[3 * node + 2];
    return side == 0 ? h - z : h + z;
  }

  /// Newton's method with the multipliers as they are; the mean force of the plates.
  double balance(double h, double penalty) {
    for (int iteration = 0; iteration < 60; ++iteration) {
      if (!this->assemble()) throw NotConverged("inverted");
      double total = 0;
      for (std::size_t side = 0; side < 2; ++side)
        for (Index r = 0; r < rows.size(); ++r) {
          const double push = multiplier[side][r] - penalty * gap_of(r, side, h);
          if (push <= 0) continue;
          total += push / 2;
          for (const auto& [a, weight_a] : rows[r].entry) {
            this->force[3 * a + 2] += (side == 0 ? push : -push) * weight_a;
            for (const auto& [b, weight_b] : rows[r].entry)
              if (a >= b)
                this->tangent.valuePtr()[this->find(3 * a + 2, 3 * b + 2)] += penalty * weight_a * weight_b;
          }
        }
      for (Index i = 0; i < this->x.size(); ++i)  // what is held below would make it singular
        this->tangent.coeffRef(i, i) += 1e-9 * this->volume[i / 3];
      this->factor.factorize(this->tangent);
      ++n_factorisations;
      if (this->factor.info() != Eigen::Success) throw NotConverged("no factorisation");
      // Bordered by the five conditions held^T (x - X) = 0.
      const Eigen::MatrixXd border = this->factor.solve(Eigen::MatrixXd(held));
      const Eigen::VectorXd free = this->factor.solve(this->force);
      const Eigen::VectorXd reaction = (held.transpose() * border)
                                           .fullPivLu()
                                           .solve(held.transpose() * (free - (this->x - this->reference)));
      const Eigen::VectorXd step = free - border * reaction;
      moment = (held.transpose() * held * reaction).tail<3>().norm() / std::max(total, 1e-12);
      const double residual = (this->force - held * reaction).norm();
      if (residual < 1e-5 * std::max(total, 1e-4) && step.norm() < 1e-3) return total;
      this->move(step);
    }
    throw NotConverged("Newton's method");
  }
};

const std::array<double, 4> approaches = {0.02, 0.05, 0.075, 0.10};

struct Options {
  Index orientations = 20;
  double poisson = 0.495;
  std::string elements, contacts = "nodes,centres", cells = "400,816", bricks = "2", out = ".";
};

/// Worst error over [0.05, 0.10] of each element and contact, over nodes and over CPU time: a table and two
/// pictures.
class Curves {
 public:
  void add(const std::string& name, Index nodes, double seconds, const std::array<double, 4>& worst) {
    double error = 0;
    for (std::size_t i = 1; i < 4; ++i) error = std::max(error, std::abs(worst[i]));
    rows_[name].push_back({std::log10(double(nodes)), std::log10(seconds), 100 * error});
  }

  void draw(const std::filesystem::path& folder) const {
    CurvePicture over_nodes{
        "log10 of nodes", "worst force error over [0.05, 0.10], %", {}, true, "right top"},
        over_time{"log10 of CPU seconds", "worst force error over [0.05, 0.10], %", {}, true, "right top"};
    for (const auto& [name, rows] : rows_) {
      const std::string file = "grain_" + name + ".csv";
      CsvWriter table(folder / file, {"log10_nodes", "log10_seconds", "worst_error_percent"});
      for (const auto& row : rows) table.write(Array<double>(row.begin(), row.end()));
      over_nodes.curves.push_back({file, "log10_nodes", "worst_error_percent", name});
      over_time.curves.push_back({file, "log10_seconds", "worst_error_percent", name});
    }
    if (rows_.empty()) return;
    jampack::draw(over_nodes, folder / "grain_error_over_nodes.png");
    jampack::draw(over_time, folder / "grain_error_over_time.png");
  }

 private:
  std::map<std::string, Array<std::array<double, 3>>> rows_;
};

Array<Index> numbers(const std::string& list) {
  Array<Index> all;
  std::stringstream rest(list);
  for (std::string word; std::getline(rest, word, ',');) {
    const auto number = to_number<Index>(word);
    require(number && *number >= 0, "'" + word + "' is no number of cells or blocks");
    if (*number > 0) all.push_back(*number);
  }
  return all;
}

template <class Element>
void press_balls(const Options& options, const Mesh<3>& mesh, CsvWriter& table, Curves& curves) {
  if (!named(options.elements, Element::name)) return;
  for (const std::string& contact : contact_names) {
    if (!named(options.contacts, contact)) continue;
    const Array<WallRow> rows = rows_of(contact, mesh);
    RandomSource random(7);
    std::array<double, 4> worst{}, mean{};
    double seconds = 0;
    Index n_done = 0, n_factorisations = 0;
    for (Index o = 0; o < options.orientations; ++o) {
      const Matrix<3> rotation = rotation_matrix<3>(random.orientation<3>());
      const double start = cpu_seconds();
      PressedBall<Element> ball(mesh, rotation, rows, options.poisson);
      try {
        std::array<double, 4> error{};
        double reached = 0;
        for (std::size_t i = 0; i < 4; ++i) {
          double force = 0;
          while (reached < approaches[i] - 1e-12) {
            const double next = std::min(reached + 0.0101, approaches[i]);
            force = ball.press(0.5 - next);
            reached = next;
          }
          const double reference = *sphere_compression_force({1, 1, options.poisson}, reached);
          error[i] = force / reference - 1;
          if (ball.moment > 0.05) std::cerr << "held by a moment of " << ball.moment << " force diameters\n";
        }
        for (std::size_t i = 0; i < 4; ++i) {
          if (std::abs(error[i]) > std::abs(worst[i])) worst[i] = error[i];
          mean[i] += error[i];
        }
        ++n_done;
      } catch (const NotConverged& failure) {
        std::cerr << Element::name << " " << contact << " orientation " << o << ": " << failure.what()
                  << "\n";
      }
      seconds += cpu_seconds() - start;
      n_factorisations += ball.n_factorisations;
    }
    const auto n = static_cast<double>(n_done);
    std::cout << std::setw(10) << Element::name << std::setw(9) << contact << std::setw(7)
              << mesh.cells.size() << std::setw(6) << mesh.nodes.size() << std::fixed << std::setprecision(1);
    for (std::size_t i = 0; i < 4; ++i)
      std::cout << std::setw(7) << 100 * mean[i] / n << " (" << std::setw(5) << 100 * worst[i] << ")";
    std::cout << std::setprecision(2) << std::setw(8) << seconds / static_cast<double>(options.orientations)
              << " s " << n_done << "/" << options.orientations << std::endl;
    if (n_done > 0)
      curves.add(std::string(Element::name) + " " + contact, mesh.nodes.size(),
                 seconds / static_cast<double>(options.orientations), worst);
    for (std::size_t i = 0; i < 4; ++i)
      table.write({"sphere", Element::name, contact, mesh.cells.size(), mesh.nodes.size(), approaches[i],
                   mean[i] / n, worst[i], n_done, seconds / static_cast<double>(options.orientations),
                   static_cast<double>(n_factorisations) / static_cast<double>(options.orientations)});
  }
}

void work_precision(CommandLine& line) {
  Options options;
  line.option("orientations", options.orientations, at_least(1), "random orientations of the mesh");
  line.option("poisson", options.poisson, strictly_between(-1, 0.5),
              "0.495 or 0.3: where there is a reference");
  line.option("elements", options.elements, "which elements, separated by commas; all by default");
  line.option("contacts", options.contacts, "which contacts: nodes, centres, samples (both), weighted");
  line.option("cells", options.cells, "wanted numbers of linear cells, separated by commas");
  line.option("bricks", options.bricks, "blocks a side of the cores of brick meshes, separated by commas");
  line.option("out", options.out, "folder for work_precision_elements.csv and pictures");
  if (!line.parse()) return;
  CsvWriter table(std::filesystem::path(options.out) / "work_precision_elements.csv",
                  {"test", "element", "contact", "cells", "nodes", "delta_over_d", "mean_error",
                   "worst_error", "n_orientations", "cpu_seconds", "n_factorisations"});
  std::cout << "force error in %, mean (worst), at delta/d = 0.02, 0.05, 0.075, 0.10; CPU seconds a ball\n";
  Curves curves;
  const auto press_all = [&](const Mesh<3>& mesh) {
    press_balls<LinearSimplex<3>>(options, mesh, table, curves);
    if (!mesh.bricks.empty()) press_balls<Brick<3>>(options, mesh, table, curves);
    if (mesh.macros.empty()) return;
    press_balls<MacroSimplex<3>>(options, mesh, table, curves);
    press_balls<CompositeSimplex<3>>(options, mesh, table, curves);
    press_balls<QuadraticSimplex<3>>(options, mesh, table, curves);
    press_balls<ResistingSimplex<3>>(options, mesh, table, curves);
  };
  for (const Index wanted : numbers(options.cells)) press_all(ball_mesh(wanted));
  for (const Index n : numbers(options.bricks))
    press_all(brick_mesh<3>({.n_core = n, .n_layers = (n + 1) / 2}));
  curves.draw(options.out);
}

}  // namespace

int main(int argc, char** argv) {
  return run_program(argc, argv, "measures the error of finite elements against CPU time", work_precision);
}
