// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/analysis/contact_network.hpp>
#include <jampack/analysis/stress_field.hpp>
#include <jampack/io/vtu.hpp>

namespace jampack {

/// The grains as linear cells, with the von Mises stress over E at the nodes and the number of the grain.
template <class Packing>
VtuGrid grains_vtu(const Packing& packing) {
  constexpr int Dim = Packing::dimension;
  VtuGrid grid;
  Array<double> stress, number;
  for (Index g = 0; g < packing.grains.size(); ++g) {
    const Index first = grid.points.size();
    const auto& x = packing.grains[g].position;
    for (Index i = 0; i < x.cols(); ++i) grid.add_point<Dim>(Vector<Dim>(x.col(i)));
    for (const auto& cell : packing.model->mesh.cells) {
      grid.add_cell(Dim == 2 ? VtkCell::triangle : VtkCell::tetrahedron, cell, first);
      number.push_back(double(g));
    }
    for (const double value : nodal_von_mises(packing, g))
      stress.push_back(value / packing.model->material.young);
  }
  grid.point_data.emplace_back("von_mises_over_E", stress);
  grid.cell_data.emplace_back("grain", number);
  return grid;
}

/// The contacts as lines from centre to centre (from contact point to centre at a wall), with the force each
/// carries, on its candidate, and where it is.
template <class Packing, int Dim>
VtuGrid contacts_vtu(const Packing& packing, const ContactNetwork<Dim>& network) {
  VtuGrid grid;
  Array<Vector<Dim>> force;
  Array<double> size, at_wall;
  for (const auto& contact : network.contacts) {
    const Vector<Dim> centre = packing.grains[contact.candidate].centre();
    const Index first = grid.add_point<Dim>(Vector<Dim>(centre - contact.branch));
    grid.add_point<Dim>(centre);
    grid.add_cell(VtkCell::line, {first, first + 1});
    force.push_back(contact.force);
    size.push_back(contact.force.norm());
    at_wall.push_back(contact.at_wall() ? 1.0 : 0.0);
  }
  grid.cell_data.push_back(VtuField("force", force));
  grid.cell_data.emplace_back("force_size", size);
  grid.cell_data.emplace_back("at_wall", at_wall);
  return grid;
}

}  // namespace jampack
