// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/body/grain.hpp>
#include <jampack/geometry/container.hpp>
#include <memory>

namespace jampack {

/// Deformable grains of one reference mesh in a closing room. Knows nothing of contact.
template <int Dim, class ElementType, class MaterialType>
struct SoftPacking {
  static constexpr int dimension = Dim;
  using Element = ElementType;
  using Material = MaterialType;
  using Model = GrainModel<Dim, Element, Material>;
  using Nodal = typename Grain<Model>::Nodal;

  std::shared_ptr<const Model> model;
  Container<Dim> room;
  Array<Grain<Model>> grains;

  SoftPacking(Mesh<Dim> mesh, const Material& material, Container<Dim> walls)
      : model(std::make_shared<const Model>(std::move(mesh), material)), room(std::move(walls)) {}

  /// Adds a stress-free grain of the reference mesh scaled by its diameter.
  void add(double diameter, const Vector<Dim>& centre,
           const Matrix<Dim>& rotation = Matrix<Dim>::Identity()) {
    grains.emplace_back(*model, diameter, centre, rotation);
  }

  Index n_nodes() const { return model->mesh.nodes.size(); }  ///< of one grain
  Index n_dofs() const { return Dim * n_nodes() * grains.size(); }
  double mean_diameter() const {
    double sum = 0;
    for (const auto& grain : grains) sum += grain.diameter;
    return sum / double(grains.size());
  }
};

}  // namespace jampack
