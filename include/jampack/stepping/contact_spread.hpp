// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/core/array.hpp>
#include <jampack/detection/surface_contact.hpp>

namespace jampack {

/// H of the contacts of a packing of deformable grains: how their forces, N unknowns each, act on the nodes,
/// and how the nodes' motions move the contacts. Kept grain by grain, so that grains can be treated in
/// parallel.
template <int Dim, int N>
class ContactSpread {
 public:
  using Axes = Eigen::Matrix<double, N, Dim>;  ///< of a contact, as rows

  explicit ContactSpread(Index n_grains = 0) : of_grain_(n_grains) {}

  /// Adds one, whose unknowns are those with number `place` and lie along `axes`.
  void add(const SurfaceContact<Dim>& contact, Index place, const Axes& axes) {
    contact.for_each_node([&](Index grain, Index node, double weight) {
      of_grain_[grain].push_back({place, node, weight * axes.transpose()});
    });
  }

  /// Adds sign H^T r to the nodal forces `load` on one grain.
  template <class Forces, class Load>
  void add_pull(Index grain, const Forces& r, double sign, Load&& load) const {
    for (const Spread& s : of_grain_[grain])
      load.template segment<Dim>(Dim * s.node) += sign * (s.axes * r.template segment<N>(N * s.place));
  }

  /// Adds H dx to u; moved(grain) is dx of a grain.
  template <class Moved>
  void add_motion(Moved&& moved, Eigen::VectorXd& u) const {
    for (Index g = 0; g < of_grain_.size(); ++g)
      for (const Spread& s : of_grain_[g])
        u.template segment<N>(N * s.place) +=
            s.axes.transpose() * moved(g).template segment<Dim>(Dim * s.node);
  }

 private:
  struct Spread {
    Index place, node;
    Eigen::Matrix<double, Dim, N> axes;  ///< with the weight and the sign of the side
  };
  Array<Array<Spread>> of_grain_;
};

}  // namespace jampack
