// SPDX-License-Identifier: MIT
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <jampack/analysis/hertz.hpp>
#include <jampack/analysis/sphere_compression_reference.hpp>
#include <jampack/element/quadratic_simplex.hpp>
#include <jampack/law/signorini_coulomb.hpp>
#include <jampack/material/neo_hookean.hpp>
#include <jampack/mesh/ball_mesh.hpp>
#include <jampack/packing/random.hpp>
#include <jampack/stepping/soft_step.hpp>

#include "../catch.hpp"

using namespace jampack;

namespace {

constexpr double poisson = 0.495;
const HertzContact hertz = hertz_sphere_on_plane({1, 1, poisson});

/// One sample that carries: its distance from the axis, its force.
struct Carrier {
  double distance, force;
};

/// A sphere of unit diameter and modulus between two plates.
struct PressedSphere {
  using Packing = SoftPacking<3, ResistingSimplex<3>, NeoHookean>;
  Packing packing;
  SoftStep<Packing, SignoriniCoulomb> step{SignoriniCoulomb{0.3}, {}};
  double reached = 0;

  PressedSphere(const Mesh<3>& mesh, const Matrix<3>& rotation)
      : packing(mesh, NeoHookean{.young = 1, .poisson = poisson}, plates<3>(1.0)) {
    packing.add(1.0, Vector<3>::Zero(), rotation);
  }

  /// Mean force of the plates at this approach of each.
  double press(double delta) {
    for (double length = 0.01; reached < delta;) {
      const double next = delta - reached <= length * 1.001 ? delta : reached + length;
      for (auto& grain : packing.grains) grain.velocity.setZero();
      if (step.advance(packing, 100, 1 - 2 * next).converged)
        reached = next;
      else
        REQUIRE((length /= 2) > 1e-5);
    }
    double force = 0;
    for (const auto& side : carriers())
      for (const auto& carrier : side) force += carrier.force / 2;
    return force;
  }

  /// Of the lower and of the upper plate.
  std::array<Array<Carrier>, 2> carriers() const {
    std::array<Array<Carrier>, 2> sides;
    const auto& walls = step.contacts.walls;
    for (Index c = 0; c < walls.size(); ++c) {
      const Vector<3> at = weighted_point(walls.contact[c].own, packing.grains[0].position);
      if (walls.reaction[c][0] > 0) sides[at[2] > 0].push_back({at.head<2>().norm(), walls.reaction[c][0]});
    }
    return sides;
  }
};

/// Length of an edge of a linear cell on the surface: quadratic faces are four of these each.
double edge_length(const Mesh<3>& mesh) {
  return std::sqrt(std::numbers::pi / double(4 * mesh.faces.size()) / (std::sqrt(3.0) / 4));
}

/// The straight line a + b x through the points, at x = 0.
double at_no_approach(const Array<double>& x, const Array<double>& y) {
  Eigen::MatrixXd basis(x.size(), 2);
  Eigen::VectorXd values(x.size());
  for (Index i = 0; i < x.size(); ++i) {
    basis.row(i) << 1, x[i];
    values[i] = y[i];
  }
  return basis.householderQr().solve(values)[0];
}

Matrix<3> upwards(const Vector<3>& direction) {
  return Eigen::Quaterniond::FromTwoVectors(direction, Vector<3>::UnitZ()).toRotationMatrix();
}

}  // namespace

TEST_CASE("a sphere between plates: radius and pressure of its contacts, and Hertz's prefactor") {
  const auto mesh = ball_mesh(6656);
  const double edge = edge_length(mesh);
  RandomSource random(3);
  PressedSphere sphere(mesh, rotation_matrix<3>(random.orientation<3>()));
  Array<double> approaches, found, exact;
  for (const double delta : {0.02, 0.03, 0.05, 0.075, 0.10}) {
    const double force = sphere.press(delta);
    const double reference = *sphere_compression_force({1, 1, poisson}, delta);
    approaches.push_back(delta);
    found.push_back(force / hertz.force(delta));
    exact.push_back(reference / hertz.force(delta));
    const double radius = hertz.contact_radius(hertz.approach(reference));
    for (const auto& side : sphere.carriers()) {
      double total = 0, moment = 0, outermost = 0;
      for (const auto& [distance, carried] : side) {
        total += carried;
        moment += carried * distance * distance;
        outermost = std::max(outermost, distance);
      }
      INFO("delta/d " << delta << ": radius " << radius << ", by the second moment "
                      << std::sqrt(2.5 * moment / total) << ", of the outermost sample " << outermost);
      CHECK(std::abs(std::sqrt(2.5 * moment / total) - radius) < edge / 4);  // 2 a^2 / 5 in theory
      CHECK(std::abs(outermost - radius) < edge / 2);
      // The force within a distance from the axis, each sample's spread over an edge.
      double worst = 0;
      for (double r = 0; r < radius + edge; r += 0.01 * radius) {
        double within = 0;
        for (const auto& [distance, carried] : side)
          within += carried / total * std::clamp((r - distance) / edge + 0.5, 0.0, 1.0);
        const double share = std::min(1.0, r / radius);
        worst = std::max(worst, std::abs(within - 1 + std::pow(1 - share * share, 1.5)));
      }
      INFO("pressure " << worst);
      CHECK(worst < (delta < 0.04 ? 0.2 : 0.1));
    }
  }
  const double prefactor = at_no_approach(approaches, found), converged = at_no_approach(approaches, exact);
  INFO("prefactor " << prefactor << ", of the converged force " << converged);
  CHECK(std::abs(prefactor - 1) < 0.03);
  CHECK(std::abs(prefactor / converged - 1) < 0.03);
}

TEST_CASE("a sphere between plates: a corner, the middle of an edge or of a face first; 40 % compression") {
  const auto mesh = ball_mesh(816);
  const auto& face = mesh.faces[5];
  const Vector<3> corner = mesh.nodes[face.node[0]], middle = mesh.nodes[face.node[3]],
                  centre = mesh.nodes[face.node[0]] + mesh.nodes[face.node[1]] + mesh.nodes[face.node[2]];
  std::array<double, 2> range{1, -1};  // of the errors over [0.05, 0.10]
  for (const auto& first : {corner, middle, centre}) {
    PressedSphere sphere(mesh, upwards(first));
    for (const double delta : {0.02, 0.05, 0.075, 0.10, 0.20}) {
      const double error = sphere.press(delta) / *sphere_compression_force({1, 1, poisson}, delta) - 1;
      INFO("delta/d " << delta << ": " << error);
      CHECK(std::abs(error) < (delta < 0.05 ? 0.15 : 0.05));
      if (delta < 0.05 || delta > 0.10) continue;
      range = {std::min(range[0], error), std::max(range[1], error)};
    }
  }
  CHECK(range[1] - range[0] < 0.04);
}
