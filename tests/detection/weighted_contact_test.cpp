// SPDX-License-Identifier: MIT
#include <jampack/detection/surface_detection.hpp>
#include <jampack/detection/weighted_contact.hpp>
#include <jampack/mesh/ball_mesh.hpp>
#include <jampack/mesh/disk_mesh.hpp>

#include "../catch.hpp"
#include "../element/blocks.hpp"

using namespace jampack;

namespace {

/// Two grains of unit size and nothing else.
template <int Dim>
struct Pair {
  Boundary<Dim> boundary;
  std::array<typename GrainSurface<Dim>::Nodal, 2> x;
  Array<GrainSurface<Dim>> surfaces;

  Pair(const Mesh<Dim>& mesh, const Matrix<Dim>& rotation, const Vector<Dim>& apart)
      : boundary(make_boundary(mesh)), surfaces(2) {
    for (auto& nodal : x) nodal.resize(Dim, mesh.nodes.size());
    for (Index i = 0; i < mesh.nodes.size(); ++i) {
      x[0].col(i) = mesh.nodes[i];
      x[1].col(i) = apart + rotation * mesh.nodes[i];
    }
    for (std::size_t g = 0; g < 2; ++g) surfaces[Index(g)].update(boundary, x[g], 1.0);
  }

  Array<SurfaceContact<Dim>> contacts(double reach) const {
    Array<SurfaceContact<Dim>> pairs, walls;
    detect(WeightedContact{}, surfaces, container(centred_cube<Dim>(10.0)), {.reach = reach, .depth = 0.1},
           {}, pairs, walls);
    return pairs;
  }
};

double sum(const NodeWeights& weights) {
  double total = 0;
  for (const auto& entry : weights) total += entry.weight;
  return total;
}

/// The gap of a dual cell of the first grain, by the projections of a fine grid of points: along the normal
/// of the second grain, where a contact has it along the mean of both.
template <int Dim>
double mean_gap(const Pair<Dim>& pair, Index node) {
  constexpr int n = 24;
  double gaps = 0, area = 0;
  const auto& boundary = pair.boundary;
  for (const auto& [p, corner] : boundary.parts.of_node[node]) {
    const auto& part = boundary.parts.part[p];
    Eigen::Matrix<double, Dim, Dim - 1> tangent;
    for (std::size_t i = 1; i < Dim; ++i)
      tangent.col(Index(i) - 1) = pair.x[0].col(part.node[i]) - pair.x[0].col(part.node[0]);
    const double size = face_normal<Dim>(tangent).norm();
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < (Dim == 2 ? 1 : n); ++j) {
        std::array<double, 3> b{1 - (i + 0.5) / n, (i + 0.5) / n, 0};
        if (Dim == 3) {
          b = {(i + 1.0 / 3) / n, (j + 1.0 / 3) / n, 0};
          b[2] = 1 - b[0] - b[1];
          if (b[2] < 0) continue;
        }
        if (std::max_element(b.begin(), b.begin() + Dim) - b.begin() != std::ptrdiff_t(corner)) continue;
        FaceCoordinates<Dim> xi = FaceCoordinates<Dim>::Zero();
        for (std::size_t k = 0; k < Dim; ++k) xi += b[k] * face_node_coordinates<Dim>(part.local[k]);
        gaps += size * pair.surfaces[1].project(pair.surfaces[0].point(part.face, xi)).gap;
        area += size;
      }
  }
  return gaps / area;
}

}  // namespace

TEST_CASE("on flat faces the two means of a contact lie opposite each other, whatever the meshes") {
  using namespace jampack_tests;
  Mesh<3> mesh = extruded(triangles(3, 3,
                                    [](double x, double y) {
                                      return Vector<2>(x + 0.3 * x * (1 - x) * (0.2 + y) - 0.5,
                                                       y + 0.35 * y * (1 - y) * (0.3 + x) - 0.5);
                                    }),
                          1.0, 2);
  for (auto& node : mesh.nodes) node[2] -= 0.5;
  add_macros(mesh, straight<3>);
  // Turned over, with the lower face where the upper one was: other nodes lie there.
  const Matrix<3> over = Vector<3>(1, -1, -1).asDiagonal();
  const Pair<3> pair(mesh, over, {0.1, -0.05, 1.003});
  const auto contacts = pair.contacts(0.02);
  REQUIRE(contacts.size() >= 40);
  for (const auto& contact : contacts) {
    CHECK(contact.candidate == 0);
    CHECK(sum(contact.own) == Approx(1));
    CHECK(sum(contact.other) == Approx(1));
    CHECK(contact.gap == Approx(0.003));
    const Vector<3> apart = weighted_point(contact.own, pair.x[0]) - weighted_point(contact.other, pair.x[1]);
    CHECK((apart - contact.gap * contact.normal).norm() < 1e-12);
    CHECK((contact.normal + Vector<3>::UnitZ()).norm() < 1e-12);
  }
}

TEST_CASE("the gap of a cell is the mean of the gaps between curved faces") {
  const Pair<3> balls(
      ball_mesh(3000),
      rotation_matrix<3>(Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vector<3>(1, 2, 3).normalized()))),
      {0.3, 0.2, std::sqrt(0.98 * 0.98 - 0.13)});
  const auto contacts = balls.contacts(-0.003);  // all of the cell faces the other ball
  REQUIRE(contacts.size() >= 3);
  for (const auto& contact : contacts)
    CHECK(contact.gap == Approx(mean_gap(balls, contact.sample)).margin(5e-4));
  const Pair<2> disks(disk_mesh(600), Eigen::Rotation2Dd(0.2).toRotationMatrix(), {0.98 * 0.6, 0.98 * 0.8});
  const auto at_disks = disks.contacts(-0.003);
  REQUIRE(at_disks.size() >= 2);
  for (const auto& contact : at_disks)
    CHECK(contact.gap == Approx(mean_gap(disks, contact.sample)).margin(5e-4));
}
