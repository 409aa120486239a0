// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/core/array.hpp>
#include <jampack/core/parallel.hpp>
#include <string>

namespace jampack {

/// How one implicit step is solved. docs/results/compaction.md says how the defaults came about.
struct SoftStepOptions {
  double theta = 1;                       ///< of the Moreau-Jean scheme, in [0.5, 1]
  double tolerance = 8e-7;                ///< on the equilibrium residual
  double scaled_tolerance = 8e-7;         ///< on the scaled contact residual
  double surface_tolerance = 2e-5;        ///< on the contact residual with the stiffness of the surface
  double fresh_tolerance = 6e-4;          ///< on the equilibrium residual with contact detected afresh
  double fresh_contact_tolerance = 5e-3;  ///< on that contact residual then
  int max_iterations = 60;                ///< condensed contact problems before the step is given up
  double penalty = 10;  ///< augmentation, in units of the stiffness of a surface layer one edge thick
  double contact_tolerance = 1e-2;  ///< of condensed contact problems, at most
  double reach = 0.03;              ///< detection distance over the mean diameter
  double least_pressure = 1e-6;     ///< forces below this times Young's modulus and d^(Dim-1) are none
  Threads threads;
};

/// Where a step begins to look for its end.
enum class FirstGuess {
  flight,  ///< where the grains get with the velocities they have
  rest,    ///< where they are: velocities that were given them tell nothing of what contacts will do
};

/// What becomes of a step that ends without balance.
enum class Unfinished {
  undone,  ///< all is as it was
  kept,    ///< where it came near to it: enough on the way to rest, where only the end counts
};

/// What one step cost and reached.
struct SoftStepReport {
  bool converged = false;
  bool kept = false;          ///< not converged, but near balance and kept
  bool near_balance = false;  ///< not converged, but balance and law hold to a hundredth
  int iterations = 0;
  Index sweeps = 0;                 ///< of the contact solver, or what it counts
  double equilibrium_residual = 0;  ///< |M dv - h (f_ext - f_int) - H^T r| / |H^T r|, the step's own frames
  double scaled_residual = 0;       ///< of the contacts, the step's own frames
  double fresh = 0;                 ///< equilibrium_residual with contact detected afresh
  std::string reason;               ///< why it failed
};

}  // namespace jampack
