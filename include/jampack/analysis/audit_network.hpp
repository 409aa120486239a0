// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/analysis/audit_report.hpp>
#include <jampack/analysis/audit_state.hpp>
#include <jampack/analysis/audit_surface.hpp>
#include <jampack/mesh/boundary_surface.hpp>
#include <map>
#include <utility>

namespace jampack {

/// A contact point of a stored state, found afresh.
template <int Dim>
struct AuditContact {
  Index candidate, antagonist;  ///< antagonist: grain, or -1 - wall
  const typename Boundary<Dim>::Sample* sample;
  Vector<Dim> force;                             ///< on the candidate
  typename AuditSurface<Dim>::Projection at;     ///< found afresh
  typename AuditSurface<Dim>::Projection frame;  ///< as the step had it; `at` where the step had none
  double slack;                                  ///< how far the sample may enter, length
  Index n_unknowns;
};

/// Vector sums of the points between each two bodies, and what follows from them: pressure on the walls and
/// their balance, the grains' balance, coordination.
template <int Dim>
void audit_network(const StoredState<Dim>& state, double mean_diameter,
                   const Array<AuditContact<Dim>>& points, AuditReport& report) {
  const Index n = state.grains.size(), n_walls = state.room.n_walls();
  std::map<std::pair<Index, Index>, Vector<Dim>> total;  // lower grain (or grain at a wall), other
  Array<double> wall_force(n_walls, 0.0);
  for (const auto& point : points) {
    if (point.force.isZero(0)) continue;
    ++report.n_contact_points;
    const bool swapped = point.antagonist >= 0 && point.antagonist < point.candidate;
    const std::pair key =
        swapped ? std::pair(point.antagonist, point.candidate) : std::pair(point.candidate, point.antagonist);
    const Vector<Dim> force = swapped ? Vector<Dim>(-point.force) : point.force;
    if (const auto [place, is_new] = total.emplace(key, force); !is_new) place->second += force;
    if (point.antagonist < 0) wall_force[-1 - point.antagonist] += point.force.dot(point.at.normal);
  }
  double all_walls = 0;
  for (Index w = 0; w < n_walls; ++w) {
    all_walls += wall_force[w] / double(n_walls);
    report.pressure += wall_force[w] * state.room.scale * state.room.distance[w] / (Dim * report.room_volume);
  }
  for (Index v = 0; v < n_walls; ++v)
    for (Index w = 0; w < v; ++w)
      if (state.room.normal[v].dot(state.room.normal[w]) < -1 + 1e-12 && all_walls > 0)
        report.wall_imbalance =
            std::max(report.wall_imbalance, std::abs(wall_force[v] - wall_force[w]) / all_walls);

  const double counts = 1e-4 * report.pressure * std::pow(mean_diameter, Dim - 1);
  Array<Vector<Dim>> net(n, Vector<Dim>::Zero());
  Array<double> sum(n, 0.0);
  for (const auto& [bodies, force] : total) {
    const auto [a, b] = bodies;
    net[a] += force;
    sum[a] += force.norm();
    if (b >= 0) {
      net[b] -= force;
      sum[b] += force.norm();
    }
    if (force.norm() <= counts) continue;
    (b >= 0 ? report.coordination : report.wall_contacts) += (b >= 0 ? 2.0 : 1.0) / double(n);
  }
  // A grain whose forces are too small to count as contacts is loose and may fly.
  for (Index g = 0; g < n; ++g)
    if (sum[g] > counts) report.grain_imbalance = std::max(report.grain_imbalance, net[g].norm() / sum[g]);
}

}  // namespace jampack
