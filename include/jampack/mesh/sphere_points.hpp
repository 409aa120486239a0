// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <jampack/core/array.hpp>
#include <jampack/core/dimension.hpp>
#include <jampack/core/error.hpp>
#include <numbers>

namespace jampack {

/// n >= 4 well-spread points on the unit sphere: a Fibonacci spiral relaxed by the repulsion of equal charges
/// (Thomson's problem) with 100 projected gradient steps. Deterministic; cost O(n^2) a step.
inline Array<Vector<3>> sphere_points(Index n) {
  require(n >= 4, "sphere_points: at least 4 points are needed");
  const double golden_angle = std::numbers::pi * (3 - std::sqrt(5.0));
  Array<Vector<3>> points(n, Vector<3>::Zero());
  for (Index i = 0; i < n; ++i) {
    const double z = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(n);
    const double angle = golden_angle * static_cast<double>(i), r = std::sqrt(1 - z * z);
    points[i] = {r * std::cos(angle), r * std::sin(angle), z};
  }
  Array<Vector<3>> force(n, Vector<3>::Zero()), trial = force, trial_force = force;
  const auto energy_and_force = [n](const Array<Vector<3>>& at, Array<Vector<3>>& f) {
    double energy = 0;
    f.assign(n, Vector<3>::Zero());
    for (Index i = 0; i < n; ++i)
      for (Index j = 0; j < i; ++j) {
        const Vector<3> d = at[i] - at[j];
        const double inverse = 1 / d.norm();
        energy += inverse;
        f[i] += d * (inverse * inverse * inverse);
        f[j] -= d * (inverse * inverse * inverse);
      }
    return energy;
  };
  double energy = energy_and_force(points, force);
  double step = std::pow(static_cast<double>(n), -1.5);  // of the order of spacing cubed
  for (int iteration = 0; iteration < 100; ++iteration) {
    for (Index i = 0; i < n; ++i)
      trial[i] = (points[i] + step * (force[i] - points[i] * points[i].dot(force[i]))).normalized();
    const double trial_energy = energy_and_force(trial, trial_force);
    if (trial_energy < energy) {
      energy = trial_energy;
      std::swap(points, trial);
      std::swap(force, trial_force);
      step *= 1.3;
    } else {
      step *= 0.4;
    }
  }
  return points;
}

/// Convex hull of points on a sphere, outward triangles (their Delaunay triangulation on the sphere; 2n - 4
/// of them). Incremental, O(n^2). Throws InvalidInput if points coincide or do not surround the origin.
inline Array<std::array<Index, 3>> sphere_triangulation(const Array<Vector<3>>& points) {
  const auto sees = [&](const std::array<Index, 3>& t, const Vector<3>& p) {
    const Vector<3>& a = points[t[0]];
    return (points[t[1]] - a).cross(points[t[2]] - a).dot(p - a) > 1e-12;
  };
  const Index n = points.size();
  require(n >= 4, "sphere_triangulation: at least 4 points are needed");
  // A first tetrahedron that is not flat: any point out of the plane of 0, 1, 2.
  Index apex = 3;
  const auto height = [&](Index i) {
    return (points[1] - points[0]).cross(points[2] - points[0]).dot(points[i] - points[0]);
  };
  for (Index i = 4; i < n; ++i)
    if (std::abs(height(i)) > std::abs(height(apex))) apex = i;
  const bool below = height(apex) < 0;
  const Index a = 0, b = below ? 1 : 2, c = below ? 2 : 1;
  Array<std::array<Index, 3>> hull{{a, b, c}, {a, c, apex}, {c, b, apex}, {b, a, apex}}, next;
  for (Index i = 3; i < n; ++i) {
    if (i == apex) continue;
    next.clear();
    Array<std::array<Index, 2>> rim;  // directed edges of the part that sees point i
    for (const auto& t : hull) {
      if (!sees(t, points[i])) {
        next.push_back(t);
        continue;
      }
      for (std::size_t e = 0; e < 3; ++e) rim.push_back({t[e], t[(e + 1) % 3]});
    }
    for (const auto& e : rim)
      if (std::find(rim.begin(), rim.end(), std::array<Index, 2>{e[1], e[0]}) == rim.end())
        next.push_back({e[0], e[1], i});
    std::swap(hull, next);
  }
  require(hull.size() == 2 * n - 4, "sphere_triangulation: points coincide or do not lie on a sphere");
  return hull;
}

}  // namespace jampack
