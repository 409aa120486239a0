// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/LU>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <jampack/core/parallel.hpp>
#include <jampack/problem/grain_compliance_delassus.hpp>
#include <jampack/solver/contact_groups.hpp>
#include <vector>

namespace jampack {

/// Factors of the Newton matrix A W + C between deformable grains, where all contacts of a grain are coupled:
/// contacts of the same two bodies see the same others and form a *group*. Multifrontal (I. S. Duff and
/// J. K. Reid, ACM Trans. Math. Softw. 9 (1983) 302): a front is a dense matrix of the groups eliminated in
/// it and of the later groups they are coupled to. Pivoting is within a front's own groups.
template <int N>
class MultifrontalLU {
 public:
  using Delassus = GrainComplianceDelassus<N>;
  using Block = Eigen::Matrix<double, N, N>;

  /// `w` must outlive the factors; `groups` are its contacts by bodies.
  MultifrontalLU(const Delassus& w, const Array<ContactGroup>& groups, Threads threads)
      : w_(w), threads_(threads) {
    Array<Array<Index>> groups_of_grain(w.n_grains());
    for (Index k = 0; k < groups.size(); ++k)
      w.for_each_body(groups[k].contacts.front(), [&](Index grain) { groups_of_grain[grain].push_back(k); });
    analyse(groups_of_grain, groups);
  }

  /// Floating-point operations of a factorisation.
  double work(const Array<int>& n_rows) const {
    double sum = 0;
    const auto size = [&](const Array<Index>& groups) {
      double n = 0;
      for (const Index group : groups)
        for (const Index c : groups_[group].contacts) n += n_rows[c];
      return n;
    };
    for (const Front& front : fronts_) {
      const double own = size(front.own), later = size(front.later);
      sum += 2 * own * (own * own / 3 + own * later + later * later);
    }
    return sum;
  }

  /// As NewtonMatrix::solve.
  bool solve(const Array<int>& n_rows, const Array<Block>& a, const Array<Block>& constant,
             Eigen::VectorXd& x) {
    if (!factorise(n_rows, a, constant)) return false;
    substitute(x);
    return x.allFinite();
  }

  /// False if the matrix has no factors.
  bool factorise(const Array<int>& n_rows, const Array<Block>& a, const Array<Block>& constant) {
    n_rows_ = n_rows;
    for (auto& group : groups_) {
      group.size = 0;
      for (const Index c : group.contacts) group.size += n_rows[c];
    }
    for (Front& front : fronts_) {
      lay_out(front);
      const Index size = front.size, rest = front.rest;
      front.matrix.setZero(size + rest, size + rest);
      for (const Index group : front.own) assemble(group, front.matrix, a, constant);
      for (const Index child : front.children) extend_add(fronts_[child], front.matrix);
      if (size == 0) continue;
      front.pivot.compute(front.matrix.topLeftCorner(size, size));
      if (!(front.pivot.matrixLU().diagonal().cwiseAbs().minCoeff() > 0)) return false;
      eliminate(front);
      if (!front.upper.allFinite()) return false;
    }
    return true;
  }

  /// With the last factors.
  void substitute(Eigen::VectorXd& x) const {
    // y holds the unknowns group by group in the order of elimination.
    Array<Index> start(groups_.size() + 1, 0);
    for (Index g = 0; g < groups_.size(); ++g) start[g + 1] = start[g] + groups_[g].size;
    Eigen::VectorXd y(start.back()), own, later;
    const auto for_each_unknown = [&](auto visit) {
      Index i = 0;
      for (const Group& group : groups_)
        for (const Index c : group.contacts)
          for (int row = 0; row < n_rows_[c]; ++row) visit(y[i++], x[N * c + row]);
    };
    // Visits the parts of y and of `values` that belong to the same group.
    const auto match = [&](const Array<Index>& groups, Eigen::VectorXd& values, auto visit) {
      Index i = 0;
      for (const Index g : groups) {
        visit(y.segment(start[g], groups_[g].size), values.segment(i, groups_[g].size));
        i += groups_[g].size;
      }
    };
    const auto read = [](auto of_y, auto value) { value = of_y; };
    const auto write = [](auto of_y, auto value) { of_y = value; };
    const auto subtract = [](auto of_y, auto value) { of_y -= value; };

    for_each_unknown([](double& of_y, double of_x) { of_y = of_x; });
    for (const Front& front : fronts_) {
      if (front.size == 0) continue;
      own.resize(front.size);
      match(front.own, own, read);
      own = front.pivot.solve(own).eval();
      match(front.own, own, write);
      later.noalias() = front.matrix.bottomLeftCorner(front.rest, front.size) * own;
      match(front.later, later, subtract);
    }
    for (Index f = fronts_.size() - 1; f >= 0; --f) {
      const Front& front = fronts_[f];
      if (front.size == 0 || front.rest == 0) continue;
      later.resize(front.rest);
      match(front.later, later, read);
      own.noalias() = front.upper * later;
      match(front.own, own, subtract);
    }
    for_each_unknown([](double of_y, double& of_x) { of_x = of_y; });
  }

 private:
  /// Contacts between the same two bodies.
  struct Group {
    Array<Index> contacts;
    Array<Index> coupled;  ///< later groups that W couples it to
    Index size = 0;        ///< unknowns
  };
  struct Front {
    Array<Index> own;       ///< groups eliminated here; all have the same later ones
    Array<Index> later;     ///< ascending
    Array<Index> children;  ///< fronts whose first later group is eliminated here
    Index size = 0;         ///< unknowns of its own groups
    Index rest = 0;         ///< and of the later ones
    Eigen::MatrixXd matrix;
    Eigen::PartialPivLU<Eigen::MatrixXd> pivot;  ///< of the own groups' block
    Eigen::MatrixXd upper;                       ///< pivot^-1 (block right of it)
  };

  void analyse(const Array<Array<Index>>& groups_of_grain, const Array<ContactGroup>& groups) {
    const Index n = groups.size();
    std::vector<Eigen::Triplet<double>> entries;
    for (const auto& coupled : groups_of_grain)
      for (const Index i : coupled)
        for (const Index j : coupled) entries.emplace_back(static_cast<int>(i), static_cast<int>(j), 1.0);
    Eigen::SparseMatrix<double> pattern(n, n);
    pattern.setFromTriplets(entries.begin(), entries.end());
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
    Eigen::AMDOrdering<int>()(pattern, order);
    Array<Index> place(n);
    for (Index k = 0; k < n; ++k) place[order.indices()[k]] = k;
    groups_.resize(n);
    offset_.resize(n);
    Array<Array<Index>> later(n), children(n);
    for (Index k = 0; k < n; ++k) {
      const int group = order.indices()[k];
      groups_[k].contacts = groups[group].contacts;
      for (Eigen::SparseMatrix<double>::InnerIterator entry(pattern, group); entry; ++entry)
        if (place[entry.row()] > k) groups_[k].coupled.push_back(place[entry.row()]);
      later[k] = groups_[k].coupled;
      for (const Index child : children[k])
        for (const Index l : later[child])
          if (l > k) later[k].push_back(l);
      std::sort(later[k].begin(), later[k].end());
      later[k].erase(std::unique(later[k].begin(), later[k].end()), later[k].end());
      if (!later[k].empty()) children[later[k].front()].push_back(k);
    }
    // A group whose later ones are the next group and that one's later ones shares its front.
    Array<Index> front_of(n);
    for (Index k = 0; k < n; ++k) {
      const bool shared = k > 0 && !later[k - 1].empty() && later[k - 1].front() == k &&
                          later[k - 1].size() == later[k].size() + 1;
      if (!shared) fronts_.emplace_back();
      front_of[k] = fronts_.size() - 1;
      Front& front = fronts_.back();
      front.own.push_back(k);
      front.later = later[k];
    }
    for (Index f = 0; f < fronts_.size(); ++f)
      if (!fronts_[f].later.empty()) fronts_[front_of[fronts_[f].later.front()]].children.push_back(f);
  }

  /// Where the groups of a front lie in its matrix, and its size.
  void lay_out(Front& front) {
    Index end = 0;
    const auto place = [&](Index group) {
      offset_[group] = end;
      end += groups_[group].size;
    };
    for (const Index group : front.own) place(group);
    front.size = end;
    for (const Index group : front.later) place(group);
    front.rest = end - front.size;
  }

  /// A W + C: the group's own rows, and its columns in the rows of later groups.
  void assemble(Index group, Eigen::MatrixXd& matrix, const Array<Block>& a, const Array<Block>& constant) {
    const auto add = [&](Index rows_of, Index columns_of) {
      Index i = offset_[rows_of];
      for (const Index c : groups_[rows_of].contacts) {
        Index j = offset_[columns_of];
        for (const Index d : groups_[columns_of].contacts) {
          if (n_rows_[c] > 0 && n_rows_[d] > 0) {
            const Block block = a[c] * w_.block(c, d);
            matrix.block(i, j, n_rows_[c], n_rows_[d]) += block.topLeftCorner(n_rows_[c], n_rows_[d]);
          }
          j += n_rows_[d];
        }
        i += n_rows_[c];
      }
    };
    add(group, group);
    for (const Index later : groups_[group].coupled) {
      add(group, later);
      add(later, group);
    }
    Index i = offset_[group];
    for (const Index c : groups_[group].contacts) {
      matrix.block(i, i, n_rows_[c], n_rows_[c]) += constant[c].topLeftCorner(n_rows_[c], n_rows_[c]);
      i += n_rows_[c];
    }
  }

  /// Eliminates the front's own groups from the later ones, some columns at a time.
  void eliminate(Front& front) {
    constexpr Index chunk = 96;
    const Index size = front.size, rest = front.rest;
    front.upper.resize(size, rest);
    parallel_for(threads_, (rest + chunk - 1) / chunk, [&](Index k) {
      const Index first = k * chunk, n = std::min(chunk, rest - first);
      auto upper = front.upper.middleCols(first, n);
      upper = front.pivot.solve(front.matrix.block(0, size + first, size, n));
      front.matrix.block(size, size + first, rest, n).noalias() -=
          front.matrix.bottomLeftCorner(rest, size) * upper;
    });
  }

  /// Adds what elimination left of `child` to the matrix of the front laid out last.
  void extend_add(const Front& child, Eigen::MatrixXd& matrix) {
    Index j = child.size;
    for (const Index column : child.later) {
      Index i = child.size;
      for (const Index row : child.later) {
        matrix.block(offset_[row], offset_[column], groups_[row].size, groups_[column].size) +=
            child.matrix.block(i, j, groups_[row].size, groups_[column].size);
        i += groups_[row].size;
      }
      j += groups_[column].size;
    }
  }

  const Delassus& w_;
  Threads threads_;
  Array<int> n_rows_;
  Array<Group> groups_;  ///< in the order of elimination
  Array<Front> fronts_;
  Array<Index> offset_;  ///< of each group in the front at hand
};

}  // namespace jampack
