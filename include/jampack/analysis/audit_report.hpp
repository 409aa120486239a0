// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/core/array.hpp>
#include <limits>
#include <string>

namespace jampack {

/// What a state may at most show.
struct AuditBounds {
  double equilibrium_residual = 1e-3;
  double step_residual = 1e-6;
  double scaled_residual = 1e-6;
  double grain_imbalance = 1e-3;
  double balance_pressure = 0;  ///< grain_imbalance is held to its bound above this pressure only
  double kinematic_error = 1e-9;
  double max_penetration_over_d = 5e-3;
  double overlap_over_solid = 2e-3;
  double self_penetration_over_d = 5e-3;
  double wall_imbalance = 1e-2;  ///< held above balance_pressure only
};

/// What the audit found in a state.
struct AuditReport {
  double equilibrium_residual = 0;  ///< |M dv - h (f_ext - f_int) - H^T r| / |H^T r|, H detected afresh
  double step_residual = 0;         ///< the same with H as the step had it
  double scaled_residual = 0;  ///< natural map of the contact conditions, gaps and slips as the step had them
  double grain_imbalance = 0;  ///< max over loaded grains of |sum F| / sum |F|
  double kinematic_error = 0;  ///< max |x1 - x0 - h (theta v1 + (1 - theta) v0)| / <d>
  double max_penetration_over_d = 0;
  double overlap_over_solid = 0;
  double self_penetration_over_d = 0;  ///< of non-adjacent faces of one grain
  double min_jacobian = 0;
  double solid_volume = 0;
  double room_volume = 0;
  double packing_fraction = 0;
  double pressure = 0;         ///< on the walls, (1 / (D V)) sum_w F_w distance_w
  double wall_imbalance = 0;   ///< max over opposite walls of |F - F'| / mean of all walls
  double coordination = 0;     ///< 2 N_gg / N, a contact counting when |f| > 1e-4 P <d>^(D-1)
  double wall_contacts = 0;    ///< N_gw / N, likewise
  Index n_contact_points = 0;  ///< that carry force
  Index n_missed = 0;          ///< samples that penetrate and are not among the stored contacts

  /// One quantity: its bound is an upper one, or a lower one for min_jacobian; NaN where it has none.
  struct Row {
    std::string name;
    double value;
    double bound;
    bool is_good;
  };
  Array<Row> rows(const AuditBounds& bounds = {}) const {
    Array<Row> all;
    // A comparison with NaN is false: what could not be computed is out of bounds.
    const auto held = [&](std::string name, double value, double bound) {
      all.push_back({std::move(name), value, bound, value <= bound});
    };
    const auto shown = [&](std::string name, double value) {
      all.push_back({std::move(name), value, std::numeric_limits<double>::quiet_NaN(), true});
    };
    const double infinite = std::numeric_limits<double>::infinity();
    const bool loaded = pressure > bounds.balance_pressure;
    held("equilibrium_residual", equilibrium_residual, bounds.equilibrium_residual);
    held("step_residual", step_residual, bounds.step_residual);
    held("scaled_residual", scaled_residual, bounds.scaled_residual);
    held("grain_imbalance", grain_imbalance, loaded ? bounds.grain_imbalance : infinite);
    held("kinematic_error", kinematic_error, bounds.kinematic_error);
    held("max_penetration_over_d", max_penetration_over_d, bounds.max_penetration_over_d);
    held("overlap_over_solid", overlap_over_solid, bounds.overlap_over_solid);
    held("self_penetration_over_d", self_penetration_over_d, bounds.self_penetration_over_d);
    all.push_back({"min_J", min_jacobian, 0, min_jacobian > 0});
    held("wall_imbalance", wall_imbalance, loaded ? bounds.wall_imbalance : infinite);
    shown("solid_volume", solid_volume);
    shown("room_volume", room_volume);
    shown("packing_fraction", packing_fraction);
    shown("pressure", pressure);
    shown("coordination", coordination);
    shown("wall_contacts", wall_contacts);
    shown("contact_points", static_cast<double>(n_contact_points));
    shown("missed_points", static_cast<double>(n_missed));
    return all;
  }
  bool is_good(const AuditBounds& bounds = {}) const {
    for (const Row& row : rows(bounds))
      if (!row.is_good) return false;
    return true;
  }
};

}  // namespace jampack
