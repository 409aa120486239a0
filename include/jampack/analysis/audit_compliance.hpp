// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/SparseCholesky>
#include <jampack/mesh/mesh.hpp>
#include <limits>

namespace jampack {

/// Entries of the inverse of one grain's effective tangent A = M / (theta h^2) + theta K, as far as one cell
/// or one boundary face couples them: what a contact's own block W_cc is made of. They come from the factors
/// by the recurrence of Takahashi, Fagan and Chen (1973), for about the price of the factorisation.
template <class Element, class Material, int Dim>
class AuditCompliance {
 public:
  using Nodal = Eigen::Matrix<double, Dim, Eigen::Dynamic>;

  /// Where A is not positive definite, the element's definite tangent takes the place of K.
  AuditCompliance(const Mesh<Dim>& mesh, const Array<typename Element::Cell>& cells, const Material& material,
                  const Nodal& x, const Eigen::VectorXd& mass, double theta, double h) {
    for (const bool definite : {false, true}) {
      Eigen::SparseMatrix<double> a(Dim * x.cols(), Dim * x.cols());
      if (!assemble(mesh, cells, material, x, mass, theta, h, definite, a)) return;
      const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(a);
      if (factor.info() != Eigen::Success || !(factor.vectorD().array() > 0).all()) continue;
      invert(factor);
      return;
    }
  }

  /// Whether there is an inverse: not so in a state with inverted cells.
  bool is_usable() const { return diagonal_.size() > 0; }

  /// Entry (axis a of node i, axis b of node j), the nodes of one cell or of one face; NaN where there is no
  /// inverse.
  double entry(Index i, int a, Index j, int b) const {
    if (!is_usable()) return std::numeric_limits<double>::quiet_NaN();
    const int p = place_[Dim * i + a], q = place_[Dim * j + b];
    if (p == q) return diagonal_[p];
    const int column = std::min(p, q), row = std::max(p, q);
    const int* first = lower_.innerIndexPtr() + lower_.outerIndexPtr()[column];
    const int* last = lower_.innerIndexPtr() + lower_.outerIndexPtr()[column + 1];
    const int* found = std::lower_bound(first, last, row);
    return found != last && *found == row ? inverse_[found - lower_.innerIndexPtr()] : 0.0;
  }

 private:
  /// False where a cell is inverted.
  static bool assemble(const Mesh<Dim>& mesh, const Array<typename Element::Cell>& cells,
                       const Material& material, const Nodal& x, const Eigen::VectorXd& mass, double theta,
                       double h, bool definite, Eigen::SparseMatrix<double>& a) {
    constexpr int n = Element::n_nodes;
    std::vector<Eigen::Triplet<double, int>> entries;
    entries.reserve(std::size_t(cells.size()) * Dim * n * (Dim * n + 1) / 2);
    const auto add = [&](Index row, Index column, double value) {
      if (row >= column) entries.emplace_back(int(row), int(column), value);
    };
    typename Element::Nodal local, f;
    typename Element::Tangent k;
    for (const auto& cell : cells) {
      for (int i = 0; i < n; ++i) local.col(i) = x.col(cell.node[std::size_t(i)]);
      const bool good = definite ? Element::force_and_definite_tangent(cell, material, local, f, k)
                                 : Element::force_and_tangent(cell, material, local, f, k);
      if (!good) return false;
      for (int i = 0; i < Dim * n; ++i)
        for (int j = 0; j < Dim * n; ++j)
          add(Dim * cell.node[std::size_t(i / Dim)] + i % Dim,
              Dim * cell.node[std::size_t(j / Dim)] + j % Dim, theta * k(i, j));
    }
    for (const auto& face : mesh.faces)  // zeros: the face's nodes have a place in the factors
      for (Index i = 0; i < face.n_nodes; ++i)
        for (Index j = 0; j < face.n_nodes; ++j)
          for (int p = 0; p < Dim; ++p)
            for (int q = 0; q < Dim; ++q)
              add(Dim * face.node[std::size_t(i)] + p, Dim * face.node[std::size_t(j)] + q, 0);
    for (Index i = 0; i < Dim * x.cols(); ++i) add(i, i, mass[i / Dim] / (theta * h * h));
    a.setFromTriplets(entries.begin(), entries.end());
    return true;
  }

  /// A^-1 = Z with Z = D^-1 L^-1 + (I - L^T) Z, read from the last column to the first on the pattern of L.
  template <class Factor>
  void invert(const Factor& factor) {
    lower_ = factor.matrixL().nestedExpression();
    place_ = factor.permutationP().indices();
    const Eigen::VectorXd pivots = factor.vectorD();
    const Index n = pivots.size();
    diagonal_.resize(n);
    inverse_.setZero(lower_.nonZeros());
    Array<int> position(n, -1);
    const int *start = lower_.outerIndexPtr(), *row = lower_.innerIndexPtr();
    const double* l = lower_.valuePtr();
    for (Index j = n - 1; j >= 0; --j) {
      for (int p = start[j]; p < start[j + 1]; ++p) position[row[p]] = p;
      for (int p = start[j]; p < start[j + 1]; ++p) {
        const Index r = row[p];
        double sum = diagonal_[r] * l[p];
        for (int q = start[r]; q < start[r + 1]; ++q) {
          const int k = position[row[q]];
          if (k < 0) continue;
          sum += inverse_[q] * l[k];
          inverse_[k] -= inverse_[q] * l[p];
        }
        inverse_[p] -= sum;
      }
      double sum = 1 / pivots[j];
      for (int p = start[j]; p < start[j + 1]; ++p) {
        sum -= inverse_[p] * l[p];
        position[row[p]] = -1;
      }
      diagonal_[j] = sum;
    }
  }

  Eigen::SparseMatrix<double> lower_;  ///< L without its unit diagonal
  Eigen::VectorXi place_;              ///< of each unknown in the order of the factors
  Eigen::VectorXd diagonal_, inverse_;
};

}  // namespace jampack
