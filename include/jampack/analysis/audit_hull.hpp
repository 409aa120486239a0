// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <jampack/mesh/mesh.hpp>
#include <limits>

namespace jampack {

/// Half-spaces that hold the whole surface of a grain, one across each of these directions: what lies outside
/// of any of them needs no search over the faces.
template <int Dim>
class AuditHull {
 public:
  /// A quadratic side is an arc of a parabola, within the hull of its ends and the point where their tangents
  /// meet; the Bézier net of a face is made of these.
  template <class Nodal>
  AuditHull(const Mesh<Dim>& mesh, const Nodal& x, const Array<Vector<Dim>>& directions) {
    Array<Vector<Dim>> net;
    for (const auto& face : mesh.faces)
      for (std::size_t i = 0; i < std::size_t(face.n_nodes); ++i) {
        const Vector<Dim> node = x.col(face.node[i]);
        net.push_back(
            i < Dim ? node
                    : Vector<Dim>(2 * node -
                                  (x.col(face.node[i - Dim]) + x.col(face.node[(i - Dim + 1) % Dim])) / 2));
      }
    for (const auto& n : directions) {
      double height = -std::numeric_limits<double>::infinity();
      for (const auto& p : net) height = std::max(height, n.dot(p));
      planes_.push_back({n, height});
    }
  }

  /// Is x farther than `margin` outside one of the half-spaces?
  bool is_beyond(const Vector<Dim>& x, double margin) const {
    return std::any_of(planes_.begin(), planes_.end(),
                       [&](const Plane& plane) { return plane.normal.dot(x) > plane.height + margin; });
  }

 private:
  struct Plane {
    Vector<Dim> normal;
    double height;
  };
  Array<Plane> planes_;
};

}  // namespace jampack
