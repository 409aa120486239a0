// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <jampack/geometry/container.hpp>
#include <jampack/geometry/face_shape.hpp>
#include <jampack/mesh/mesh.hpp>
#include <map>
#include <string>

namespace jampack {

/// One grain of a stored state: where it is, and where it was before the last step.
template <int Dim>
struct StoredGrain {
  /// Dim x n_nodes, a node a column.
  using Nodal = Eigen::Matrix<double, Dim, Eigen::Dynamic>;
  double diameter = 1;
  Matrix<Dim> rotation = Matrix<Dim>::Identity();  ///< of the reference mesh at placement
  Nodal position, velocity;
  Nodal position_before, velocity_before;  ///< at the start of the last step
};

/// One contact point of a stored state and the force in it.
template <int Dim>
struct StoredContact {
  Index candidate = 0;   ///< grain
  Index sample = 0;      ///< of its boundary (mesh/boundary_surface.hpp)
  Index antagonist = 0;  ///< grain, or -1 - wall
  /// The frame the step used: a place on the antagonist's boundary (face -1 at a wall) and the unit normal.
  Index face = -1;
  FaceCoordinates<Dim> xi = FaceCoordinates<Dim>::Zero();
  Vector<Dim> normal = Vector<Dim>::Zero();
  double slack = 0;  ///< how far the sample may enter, length
  /// On the candidate. With one unknown the first entry is the normal force and the others are zero; with
  /// Dim it is the force in global axes.
  Vector<Dim> reaction = Vector<Dim>::Zero();

  bool is_wall() const { return antagonist < 0; }
  Index wall() const { return -1 - antagonist; }
};

/// Where the driver of a compaction stands.
struct StoredProgress {
  std::int64_t n_steps = 0, n_iterations = 0, n_failed = 0;
  double strain = 0;         ///< size of the next step
  double last_duration = 0;  ///< h of the last accepted step; 0 before the first
  double last_pressure = 0;
  double gain = 1;                                       ///< growth of ln phi over strain
  double equilibrium_residual = 0, scaled_residual = 0;  ///< as the stepper reported them
};

/// All there is to know of a packing of deformable grains between two steps, free of the types it was
/// computed with: what a checkpoint holds and the audit reads.
template <int Dim>
struct StoredState {
  std::string element;   ///< its `name`
  std::string material;  ///< "neo_hookean", "neo_hookean_quadratic" or "linear_elastic"
  double young = 1, poisson = 0.3, density = 1;
  Index n_pair_unknowns = 1;  ///< of a contact between grains: 1 (frictionless) or Dim
  double friction = 0;        ///< between grains
  double theta = 1;           ///< of the time stepping
  Container<Dim> room;
  Mesh<Dim> mesh;  ///< reference, unit diameter
  Array<StoredGrain<Dim>> grains;
  Array<StoredContact<Dim>> pairs, walls;
  StoredProgress progress;
  std::map<std::string, std::string> parameters;  ///< the program's own
};

}  // namespace jampack
