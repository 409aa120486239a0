// SPDX-License-Identifier: MIT
#pragma once

#include <concepts>
#include <jampack/core/array.hpp>
#include <jampack/mesh/mesh.hpp>
#include <string_view>

namespace jampack {

/// A finite element as a policy: its cells carry what is precomputed of the reference configuration, and all
/// functions are static. Nodal is Dim x n_nodes, degrees of freedom are Dim * local_node + axis.
template <class E, int Dim>
concept ElementCells = requires(const Mesh<Dim>& mesh, double diameter, const Matrix<Dim>& rotation,
                                const typename E::Cell& cell, typename E::Nodal& x,
                                typename E::VolumeShares& shares) {
  { E::n_nodes } -> std::convertible_to<int>;
  { E::name } -> std::convertible_to<std::string_view>;
  { E::cells(mesh, diameter, rotation) } -> std::same_as<Array<typename E::Cell>>;
  { cell.node[0] } -> std::convertible_to<Index>;
  { E::min_jacobian(cell, x) } -> std::same_as<double>;
  E::add_volume_shares(cell, shares);
};

/// Whether displacements are linear on every part of a face (mesh/surface_parts.hpp), as an element says by a
/// constant of this name: then so must be the pressures on it. Where it does not, they are the faces' own.
template <class E>
inline constexpr bool linear_on_parts = [] {
  if constexpr (requires { E::linear_on_parts; })
    return bool(E::linear_on_parts);
  else
    return false;
}();

template <class E, class M>
concept ElementEnergy = requires(const typename E::Cell& cell, const M& material, typename E::Nodal& x,
                                 typename E::Tangent& tangent) {
  { E::energy(cell, material, x) } -> std::same_as<double>;
  { E::force(cell, material, x, x) } -> std::same_as<bool>;
  { E::force_and_tangent(cell, material, x, x, tangent) } -> std::same_as<bool>;
  { E::force_and_definite_tangent(cell, material, x, x, tangent) } -> std::same_as<bool>;
};

template <class E, int Dim, class M>
concept Element = ElementCells<E, Dim> && ElementEnergy<E, M>;

}  // namespace jampack
