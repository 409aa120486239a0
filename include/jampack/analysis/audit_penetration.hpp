// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/analysis/audit_surface.hpp>
#include <jampack/core/parallel.hpp>
#include <jampack/geometry/container.hpp>

namespace jampack {

/// How far bodies lie in each other, point by point.
struct AuditPenetration {
  double depth = 0;       ///< greatest, of a grain in another or in a wall, length
  double overlap = 0;     ///< volume (area in 2D)
  double self_depth = 0;  ///< greatest, of a grain in itself, length
};

/// Tests the dense points of every surface against every other surface, every wall, and the faces of the own
/// surface that have no node in common with the point's. The overlap is the depth integrated over the area of
/// the penetrating points; between grains both sides count half. A point of a grain counts as inside itself
/// where the surface winds about a point just outside it; `self_margin` (length) says how far outside.
template <int Dim>
AuditPenetration audit_penetration(const Array<AuditSurface<Dim>>& surfaces, const Container<Dim>& room,
                                   double within, double self_margin, Threads threads) {
  Array<AuditPenetration> found(surfaces.size());
  parallel_for(threads, surfaces.size(), [&](Index a) {
    auto& own = found[a];
    const auto& surface = surfaces[a];
    const auto count = [&](double depth, double area) {
      own.depth = std::max(own.depth, depth);
      own.overlap += depth * area;
    };
    for (const auto& point : surface.points) {
      for (Index w = 0; w < room.n_walls(); ++w)
        if (const double gap = room.gap(w, point.position); gap < 0) count(-gap, point.area);
      for (Index b = 0; b < surfaces.size(); ++b) {
        if (b == a || !surfaces[b].may_reach(point.position, 0)) continue;
        const auto p = surfaces[b].project(point.position, within);
        if (p.gap < 0) count(-p.gap, 0.5 * point.area);
      }
      // A fold: a face that looks the other way is close behind the point.
      const auto opposite = [&](Index f) {
        return !surface.are_adjacent(f, point.face) && surface.middle_normal(f).dot(point.normal) < -0.2;
      };
      if (!surface.has_face_near(point.position, 0.5 * within, opposite)) continue;
      const auto p = surface.project(point.position, 0.5 * within, opposite);
      if (p.gap < 0 && surface.contains(point.position + self_margin * point.normal))
        own.self_depth = std::max(own.self_depth, -p.gap);
    }
  });
  AuditPenetration all;
  for (const auto& own : found) {
    all.depth = std::max(all.depth, own.depth);
    all.overlap += own.overlap;
    all.self_depth = std::max(all.self_depth, own.self_depth);
  }
  return all;
}

}  // namespace jampack
