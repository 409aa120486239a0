// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <jampack/core/error.hpp>
#include <jampack/problem/block_sparse_delassus.hpp>
#include <jampack/problem/delassus.hpp>
#include <jampack/problem/rows_times.hpp>
#include <string>
#include <utility>

namespace jampack {

/// One grain's part of W: the velocities of its contact points by reactions on its contact points.
template <int N>
struct GrainCompliance {
  Array<Index> contact;        ///< contacts of this grain, each once
  Array<double> sign;          ///< +1 where the grain is the candidate, -1 where it is the antagonist
  Eigen::MatrixXd compliance;  ///< N contact.size() square, in the contacts' local axes, reaction taken as +r
};

/// W = sum over grains of S^T C S with one dense C a grain; a contact belongs to one grain (a wall is the
/// other body) or to two. The signs are taken into C, and a sweep reads one long dot product a row and grain.
template <int N>
class GrainComplianceDelassus {
 public:
  static constexpr int n_unknowns = N;
  using Block = Eigen::Matrix<double, N, N>;
  /// Reactions gathered grain by grain, so that each row of C meets contiguous numbers.
  struct Motion {
    Eigen::VectorXd gathered;
  };

  /// Throws InvalidInput if a contact is out of range, has no grain or more than two, or sizes do not fit.
  GrainComplianceDelassus(Index n_contacts, Array<GrainCompliance<N>> grains)
      : places_(n_contacts), diagonal_(n_contacts, Block::Zero()) {
    for (Index g = 0; g < grains.size(); ++g) {
      GrainCompliance<N>& grain = grains[g];
      const Index size = grain.contact.size(), width = N * size;
      require(grain.sign.size() == size && grain.compliance.rows() == width &&
                  grain.compliance.cols() == width && grain.compliance.allFinite(),
              "grain compliance " + std::to_string(g) + ": sizes do not fit or a value is not finite");
      const Index start = values_.size(),
                  stride = (width + RowSums<N>::lanes - 1) / RowSums<N>::lanes * RowSums<N>::lanes;
      values_.resize(start + width * stride, 0.0);
      n_stored_ += width * width;
      for (Index i = 0; i < width; ++i)
        for (Index j = 0; j < width; ++j)
          values_[start + i * stride + j] = grain.sign[i / N] * grain.sign[j / N] * grain.compliance(i, j);
      for (Index i = 0; i < size; ++i) {
        const Index c = grain.contact[i];
        require(
            c >= 0 && c < n_contacts && places_[c].count < 2,
            "grain compliance " + std::to_string(g) + ": contact out of range or on more than two grains");
        Place& place = places_[c];
        place.part[place.count++] = {start + N * i * stride, n_gathered_, stride, n_gathered_ + N * i, g};
        diagonal_[c] += grain.sign[i] * grain.sign[i] * grain.compliance.template block<N, N>(N * i, N * i);
      }
      n_gathered_ += stride;
      members_.push_back({start, stride, std::move(grain.contact)});
    }
    for (Index c = 0; c < n_contacts; ++c)
      require(places_[c].count > 0, "grain compliances: contact " + std::to_string(c) + " is on no grain");
  }

  Index n_contacts() const { return places_.size(); }
  Index n_stored() const { return n_stored_; }  ///< stored scalars
  Index n_grains() const { return members_.size(); }
  const Block& diagonal_block(Index c) const { return diagonal_[c]; }

  /// W_cd.
  Block block(Index c, Index d) const {
    using Rows = Eigen::Matrix<double, N, N, N == 1 ? Eigen::ColMajor : Eigen::RowMajor>;
    Block sum = Block::Zero();
    for (int k = 0; k < places_[c].count; ++k)
      for (int l = 0; l < places_[d].count; ++l) {
        const Part& row = places_[c].part[k];
        const Part& column = places_[d].part[l];
        if (row.grain == column.grain)
          sum += Eigen::Map<const Rows, 0, Eigen::OuterStride<>>(
              values_.data() + row.row + column.own - column.gathered, Eigen::OuterStride<>(row.stride));
      }
    return sum;
  }

  /// All blocks of W, grain by grain: that of two contacts between the same two grains comes in two parts.
  Array<DelassusBlock<N>> blocks() const {
    Array<DelassusBlock<N>> all;
    for (Index g = 0; g < n_grains(); ++g) {
      const auto c = compliance(g).transpose();
      const Array<Index>& contact = members_[g].contact;
      for (Index i = 0; i < contact.size(); ++i)
        for (Index j = 0; j < contact.size(); ++j)
          all.push_back({contact[i], contact[j], c.template block<N, N>(N * i, N * j)});
    }
    return all;
  }

  Motion motion(const Eigen::VectorXd& r) const {
    Motion motion{Eigen::VectorXd::Zero(n_gathered_)};
    for (Index c = 0; c < n_contacts(); ++c) change(motion, c, r.template segment<N>(N * c));
    return motion;
  }

  ContactVector<N> velocity(const Motion& motion, const Eigen::VectorXd&, Index c) const {
    RowSums<N> sums;
    const Place& place = places_[c];
    for (int k = 0; k < place.count; ++k) {
      const Part& part = place.part[k];
      sums.add(values_.data() + part.row, part.stride, part.stride, motion.gathered.data() + part.gathered);
    }
    return sums.sums();
  }

  void change(Motion& motion, Index c, const ContactVector<N>& dr) const {
    const Place& place = places_[c];
    for (int k = 0; k < place.count; ++k) motion.gathered.template segment<N>(place.part[k].own) += dr;
  }

  /// Visits the one or two grains of contact c.
  template <class Visit>
  void for_each_body(Index c, Visit visit) const {
    for (int k = 0; k < places_[c].count; ++k) visit(places_[c].part[k].grain);
  }

  /// visit(grain, place) for the one or two grains of contact c, `place` its number among the grain's.
  template <class Visit>
  void for_each_place(Index c, Visit visit) const {
    for (int k = 0; k < places_[c].count; ++k) {
      const Part& part = places_[c].part[k];
      visit(part.grain, (part.own - part.gathered) / N);
    }
  }

  /// C of a grain, the signs of its contacts taken in; its columns are the rows stored (it is symmetric).
  Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>> compliance(Index grain) const {
    const Members& members = members_[grain];
    const Index width = N * members.contact.size();
    return {values_.data() + members.start, width, width, Eigen::OuterStride<>(members.stride)};
  }

  /// From now on apply() uses `product`: the same by a cheaper way than through the stored C.
  void use_product(std::function<void(const Eigen::VectorXd&, Eigen::VectorXd&)> product) {
    product_ = std::move(product);
  }

  void apply(const Eigen::VectorXd& r, Eigen::VectorXd& u) const {
    if (product_) return product_(r, u);
    const Motion moved = motion(r);
    u.resize(N * n_contacts());
    for (Index c = 0; c < n_contacts(); ++c) u.template segment<N>(N * c) = velocity(moved, r, c);
  }

 private:
  struct Part {
    Index row;       // first value of the contact's N rows
    Index gathered;  // the grain's gathered reactions
    Index stride;    // from row to row: their length, padded with zeros
    Index own;       // the contact's own place among all gathered reactions
    Index grain;
  };
  struct Place {
    int count = 0;
    Part part[2];
  };
  struct Members {
    Index start;   // of the grain's C among all values
    Index stride;  // from row to row
    Array<Index> contact;
  };
  Array<Place> places_;
  Array<Members> members_;
  Array<double> values_;
  Array<Block> diagonal_;
  Index n_gathered_ = 0, n_stored_ = 0;
  std::function<void(const Eigen::VectorXd&, Eigen::VectorXd&)> product_;
};

static_assert(DelassusOperator<GrainComplianceDelassus<3>>);

}  // namespace jampack
