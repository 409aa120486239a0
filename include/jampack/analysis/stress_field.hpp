// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <jampack/analysis/field_statistics.hpp>
#include <jampack/analysis/von_mises.hpp>
#include <jampack/body/soft_packing.hpp>
#include <jampack/material/isotropic_moduli.hpp>

namespace jampack {

/// Von Mises stress at a material point of Cauchy stress `stress` and J = det F. In 2D the stress out of the
/// plane follows from these: nu tr(stress) for linear elasticity; for the neo-Hookean solids, whose stress is
/// mu / J (B - 1) + p with det B = J^2, it is p = m - mu / J (sqrt(J^2 + (J s / mu)^2) - 1) with m the mean
/// and s the deviator (half the difference of the principal stresses) in the plane.
template <int Dim, class M>
double von_mises_at_point(const M& material, const Matrix<Dim>& stress, double dilatation) {
  if constexpr (Dim == 3) {
    return von_mises(stress);
  } else if constexpr (M::finite_strain) {
    const double mu = shear_modulus(material.young, material.poisson);
    const double mean = 0.5 * stress.trace();
    const double deviator = std::hypot(0.5 * (stress(0, 0) - stress(1, 1)), stress(0, 1));
    const double stretch = std::hypot(dilatation, dilatation * deviator / mu);
    return von_mises(stress, mean - mu / dilatation * (stretch - 1));
  } else {
    return von_mises(stress, material.poisson * stress.trace());
  }
}

/// Von Mises stress of the grains at all quadrature points, weighted with their reference volumes.
template <class Packing>
WeightedField von_mises_field(const Packing& packing) {
  WeightedField field;
  using Element = typename Packing::Element;
  const auto& material = packing.model->material;
  for (const auto& grain : packing.grains)
    for (const auto& cell : grain.cells)
      Element::for_each_point(cell, material, grain.gather(cell, grain.position),
                              [&](double volume, const auto& stress, double dilatation) {
                                field.add(von_mises_at_point(material, stress, dilatation), volume);
                              });
  return field;
}

/// Von Mises stress of a grain, a node: the mean over the points of the cells around it. For pictures.
template <class Packing>
Array<double> nodal_von_mises(const Packing& packing, Index g) {
  using Element = typename Packing::Element;
  const auto& material = packing.model->material;
  const auto& grain = packing.grains[g];
  Array<double> sum(packing.n_nodes(), 0.0), weight(packing.n_nodes(), 0.0);
  for (const auto& cell : grain.cells) {
    double cell_sum = 0, cell_volume = 0;
    Element::for_each_point(cell, material, grain.gather(cell, grain.position),
                            [&](double volume, const auto& stress, double dilatation) {
                              cell_sum += volume * von_mises_at_point(material, stress, dilatation);
                              cell_volume += volume;
                            });
    for (const Index node : cell.node) {
      sum[node] += cell_sum;
      weight[node] += cell_volume;
    }
  }
  for (Index i = 0; i < sum.size(); ++i)
    if (weight[i] > 0) sum[i] /= weight[i];
  return sum;
}

}  // namespace jampack
