// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <jampack/core/error.hpp>
#include <jampack/geometry/face_shape.hpp>
#include <jampack/mesh/mesh.hpp>
#include <jampack/mesh/surface_parts.hpp>
#include <map>
#include <utility>

namespace jampack {

/// Which samples of a surface are meant.
enum class SampleSet {
  coarse,  ///< nodes, and points that bound what happens between them
  all,     ///< and the finer ones between all of those
};

/// The closed boundary surface of a reference mesh: what all grains cut from that mesh share.
///
/// The surface is the piecewise linear or quadratic interpolation of the boundary faces; on a ball mesh
/// with quadratic faces it follows the true sphere to third order in the edge length, and flattens with
/// its nodes where the grain is pressed flat (docs/theory/deformable_stage.md, section 2).
template <int Dim>
struct Boundary {
  /// A material point of the surface: weights on nodes of one face (a node alone has n = 1).
  struct Sample {
    Index face = 0;
    FaceCoordinates<Dim> xi = FaceCoordinates<Dim>::Zero();
    Index n = 0;
    std::array<Index, max_face_nodes<Dim>> node{};
    Eigen::Matrix<double, max_face_nodes<Dim>, 1> weight;
  };

  Array<BoundaryFace<Dim>> faces;
  /// neighbour[f][k]: the face across the side on which the k-th of the coordinates (1 - sum xi, xi...)
  /// vanishes.
  Array<std::array<Index, Dim>> neighbour;
  SurfaceParts<Dim> parts;
  bool linear_on_parts = false;  ///< displacements, though the faces may be quadratic
  Array<Index> nodes;            ///< mesh indices of the boundary nodes
  Array<Index> face_of_node;     ///< one incident face of each mesh node, -1 inside
  /// Where non-penetration is enforced: nodes, then points inside faces, then finer ones between all of them.
  Array<Sample> samples;
  Index n_coarse = 0;      ///< samples before the finer ones
  double edge_length = 0;  ///< mean distance of neighbouring surface nodes, unit diameter
  // Over the diameter: the largest side of the sub-faces that samples lie on, and how far samples that are
  // not primary may enter, the finer ones farther.
  static constexpr double spacing = 0.16, entry = 1e-3, fine_entry = 2e-3;

  /// How far a sample may enter the other side, over the diameter: not at all for the nodes of the grain that
  /// leads; all other samples only bound what happens between those (docs/theory/deformable_stage.md,
  /// section 2).
  double slack(Index sample, bool leads) const {
    return leads && sample < nodes.size() ? 0.0 : sample < n_coarse ? entry : fine_entry;
  }

  Index n_samples(SampleSet set) const { return set == SampleSet::all ? samples.size() : n_coarse; }

  double node_area = 0;  ///< surface area (length in 2D) a node, unit diameter
};

/// Points of a face: the corners and centres of the sub-faces that cut each of its sides into n.
template <int Dim>
Array<FaceCoordinates<Dim>> face_samples(Index n) {
  using Xi = FaceCoordinates<Dim>;
  Array<Xi> points;
  const double side = 1 / double(n);
  for (Index i = 0; i <= n; ++i) {
    if constexpr (Dim == 2) {
      points.push_back(Xi(side * double(i)));
      if (i < n) points.push_back(Xi(side * (double(i) + 0.5)));
    } else {
      for (Index j = 0; i + j <= n; ++j) {
        points.push_back(side * Xi(double(i), double(j)));
        if (i + j + 1 <= n) points.push_back(side * Xi(double(i) + 1.0 / 3, double(j) + 1.0 / 3));
        if (i + j + 2 <= n) points.push_back(side * Xi(double(i) + 2.0 / 3, double(j) + 2.0 / 3));
      }
    }
  }
  return points;
}

namespace detail {

/// The side of a face on which coordinate k vanishes, as the sorted corners it joins.
template <int Dim>
std::array<Index, Dim - 1> side_corners(const BoundaryFace<Dim>& face, int k) {
  if constexpr (Dim == 2) {
    return {face.node[k == 0 ? 1 : 0]};
  } else {
    const auto [low, high] =
        std::minmax(face.node[std::size_t((k + 1) % 3)], face.node[std::size_t((k + 2) % 3)]);
    return {low, high};
  }
}

template <int Dim>
void link_neighbours(Boundary<Dim>& boundary) {
  boundary.neighbour.resize(boundary.faces.size());
  std::map<std::array<Index, Dim - 1>, std::pair<Index, std::size_t>> open;
  for (Index f = 0; f < boundary.faces.size(); ++f)
    for (std::size_t k = 0; k < Dim; ++k) {
      const auto side = side_corners<Dim>(boundary.faces[f], int(k));
      if (const auto other = open.find(side); other == open.end()) {
        open.emplace(side, std::pair{f, k});
      } else {
        boundary.neighbour[f][k] = other->second.first;
        boundary.neighbour[other->second.first][other->second.second] = f;
        open.erase(other);
      }
    }
  require(open.empty(), "mesh boundary: " + std::to_string(open.size()) +
                            " sides belong to one face only; a grain needs a closed surface");
}

/// Samples at these points of every face. A point on a side belongs to the first of its two faces; one at a
/// node is a sample already.
template <int Dim>
void add_face_samples(Boundary<Dim>& boundary, const Array<FaceCoordinates<Dim>>& points) {
  for (Index f = 0; f < boundary.faces.size(); ++f) {
    const auto& face = boundary.faces[f];
    for (const auto& xi : points) {
      bool is_own = true;
      for (Index i = 0; i < face.n_nodes; ++i)
        is_own = is_own && (xi - face_node_coordinates<Dim>(i)).norm() > 1e-9;
      if constexpr (Dim == 3) {
        const double b[] = {1 - xi.sum(), xi[0], xi[1]};
        for (std::size_t k = 0; k < 3; ++k) is_own = is_own && (b[k] > 1e-9 || f < boundary.neighbour[f][k]);
      }
      if (is_own)
        boundary.samples.push_back({f, xi, face.n_nodes, face.node, face_shape<Dim>(face.n_nodes, xi).value});
    }
  }
}

template <int Dim>
void place_samples(Boundary<Dim>& boundary, double side) {
  using Sample = typename Boundary<Dim>::Sample;
  for (const Index node : boundary.nodes) {
    Sample sample;
    sample.face = boundary.face_of_node[node];
    require(sample.face >= 0,
            "mesh boundary: node " + std::to_string(node) + " is listed but belongs to no face");
    const auto& face = boundary.faces[sample.face];
    std::size_t local = 0;
    while (face.node[local] != node) ++local;
    sample.xi = face_node_coordinates<Dim>(Index(local));
    sample.n = 1;
    sample.node[0] = node;
    sample.weight.setZero();
    sample.weight[0] = 1;
    boundary.samples.push_back(sample);
  }
  const Index cuts = std::max<Index>(1, Index(std::ceil(side / Boundary<Dim>::spacing)));
  const auto coarse = face_samples<Dim>(cuts);
  Array<FaceCoordinates<Dim>> fine;
  for (const auto& xi : face_samples<Dim>(2 * cuts))
    if (std::none_of(coarse.begin(), coarse.end(), [&](const auto& p) { return (p - xi).norm() < 1e-9; }))
      fine.push_back(xi);
  add_face_samples(boundary, coarse);
  boundary.n_coarse = boundary.samples.size();
  add_face_samples(boundary, fine);
}

}  // namespace detail

/// Builds the boundary surface of a mesh. Throws InvalidInput when its faces do not close.
template <int Dim>
Boundary<Dim> make_boundary(const Mesh<Dim>& mesh) {
  Boundary<Dim> boundary;
  boundary.faces = mesh.faces;
  boundary.nodes = mesh.boundary_nodes;
  boundary.face_of_node.assign(mesh.nodes.size(), -1);
  double area = 0, edges = 0, sides = 0;
  for (Index f = 0; f < mesh.faces.size(); ++f) {
    const auto& face = mesh.faces[f];
    for (Index i = 0; i < face.n_nodes; ++i) boundary.face_of_node[face.node[std::size_t(i)]] = f;
    Eigen::Matrix<double, Dim, Dim - 1> tangent;
    for (std::size_t k = 1; k < Dim; ++k)
      tangent.col(Index(k) - 1) = mesh.nodes[face.node[k]] - mesh.nodes[face.node[0]];
    area += face_normal<Dim>(tangent).norm() / (Dim == 2 ? 1 : 2);
    const double edges_a_side = face.n_nodes == Dim ? 1 : 2;
    const double side = tangent.colwise().norm().mean();
    sides += side;
    edges += side / edges_a_side;
  }
  detail::link_neighbours(boundary);
  boundary.parts = surface_parts<Dim>(boundary.faces, boundary.nodes, mesh.nodes.size());
  detail::place_samples(boundary, sides / double(mesh.faces.size()));
  boundary.edge_length = edges / double(mesh.faces.size());
  boundary.node_area = area / double(boundary.nodes.size());
  return boundary;
}

}  // namespace jampack
