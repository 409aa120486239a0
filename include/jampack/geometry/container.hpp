// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/geometry/box.hpp>

namespace jampack {

/// A convex room of plane walls that opens and closes homothetically about a centre. `scale` is its one
/// degree of freedom: every wall keeps its normal and lies at scale times its reference distance.
template <int Dim>
struct Container {
  Vector<Dim> centre = Vector<Dim>::Zero();
  Array<Vector<Dim>> normal;    ///< unit, pointing into the room
  Array<double> distance;       ///< of each wall from the centre at scale 1, > 0
  double reference_volume = 0;  ///< at scale 1 (area in 2D)
  double scale = 1;

  Index n_walls() const { return normal.size(); }
  double volume() const { return reference_volume * (Dim == 2 ? scale * scale : scale * scale * scale); }

  /// Gap between wall w and a point: >= 0 inside.
  double gap(Index w, const Vector<Dim>& point) const {
    return normal[w].dot(point - centre) + scale * distance[w];
  }
};

/// The walls of a box.
template <int Dim>
Container<Dim> container(const Box<Dim>& box) {
  require_usable(box);
  Container<Dim> room;
  room.centre = box.centre();
  room.reference_volume = box.volume();
  for (Index w = 0; w < Box<Dim>::n_walls; ++w) {
    room.normal.push_back(box.wall(w).normal);
    room.distance.push_back(0.5 * box.lengths()[w / 2]);
  }
  return room;
}

/// Two plates that face each other along the last axis, and nothing beside them: its volume stands for none.
template <int Dim>
Container<Dim> plates(double apart) {
  require(apart > 0, "plates: the distance between them must be positive");
  Container<Dim> room;
  for (const double side : {1.0, -1.0}) {
    room.normal.push_back(side * Vector<Dim>::Unit(Dim - 1));
    room.distance.push_back(0.5 * apart);
  }
  room.reference_volume = 1;
  return room;
}

/// A regular polygon with n_sides >= 3 walls whose inscribed circle has the given diameter.
inline Container<2> regular_polygon(Index n_sides, double inscribed_diameter) {
  require(n_sides >= 3 && inscribed_diameter > 0, "polygon: needs at least 3 sides and a positive diameter");
  Container<2> room;
  const double r = 0.5 * inscribed_diameter, step = 2 * std::numbers::pi / double(n_sides);
  for (Index w = 0; w < n_sides; ++w) {
    const double angle = step * double(w);
    room.normal.push_back({-std::cos(angle), -std::sin(angle)});
    room.distance.push_back(r);
  }
  room.reference_volume = double(n_sides) * r * r * std::tan(step / 2);
  return room;
}

}  // namespace jampack
