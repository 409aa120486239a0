// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/analysis/stress_field.hpp>
#include <jampack/io/coloured_surface.hpp>

namespace jampack {

/// The grains coloured by von Mises stress over E: their surfaces in 3D, their cells and outlines in 2D, and
/// the edges of the room where its walls are those of a box.
template <class Packing>
ColouredSurface picture_of(const Packing& packing) {
  constexpr int Dim = Packing::dimension;
  ColouredSurface picture = ColouredSurface::of_dimension<Dim>();
  for (Index g = 0; g < packing.grains.size(); ++g) {
    const auto& x = packing.grains[g].position;
    Array<double> stress = nodal_von_mises(packing, g);
    for (double& value : stress) value /= packing.model->material.young;
    const auto triangle = [&](Index a, Index b, Index c) {
      picture.add_triangle<Dim>({x.col(a), x.col(b), x.col(c)}, {stress[a], stress[b], stress[c]});
    };
    if constexpr (Dim == 2) {
      for (const auto& cell : packing.model->mesh.cells) triangle(cell[0], cell[1], cell[2]);
      for (const auto& face : packing.model->mesh.faces) {
        const auto& n = face.node;
        const Index middle = face.n_nodes == 3 ? n[2] : n[1];
        picture.add_line<Dim>(x.col(n[0]), x.col(middle));
        if (face.n_nodes == 3) picture.add_line<Dim>(x.col(middle), x.col(n[1]));
      }
    } else {
      for (const auto& face : packing.model->mesh.faces) {
        const auto& n = face.node;
        if (face.n_nodes == 3) {
          triangle(n[0], n[1], n[2]);
          continue;
        }
        triangle(n[0], n[3], n[5]);
        triangle(n[3], n[1], n[4]);
        triangle(n[5], n[4], n[2]);
        triangle(n[3], n[4], n[5]);
      }
    }
  }
  const auto& room = packing.room;
  if (room.n_walls() == 2 * Dim) {
    Vector<Dim> low = room.centre, high = room.centre;
    bool is_box = true;
    for (Index w = 0; w < room.n_walls(); ++w) {
      const double side = room.normal[w][w / 2];
      is_box = is_box && side == (w % 2 == 0 ? 1 : -1);
      (w % 2 == 0 ? low : high)[w / 2] -= side * room.scale * room.distance[w];
    }
    if (is_box) picture.add_box<Dim>(low, high);
  }
  return picture;
}

}  // namespace jampack
