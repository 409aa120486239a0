// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <jampack/core/aligned_scalars.hpp>
#include <jampack/core/error.hpp>
#include <jampack/problem/block_sparse_delassus.hpp>
#include <jampack/problem/delassus.hpp>
#include <jampack/problem/rows_times.hpp>
#include <numeric>
#include <string>
#include <utility>

namespace jampack {

/// One grain's part of W: the velocities of its contact points by reactions on its contact points.
template <int N>
struct GrainCompliance {
  Array<Index> contact;        ///< contacts of this grain, each once
  Array<double> sign;          ///< +1 where the grain is the candidate, -1 where it is the antagonist
  Eigen::MatrixXd compliance;  ///< square, in the contacts' local axes, reaction taken as +r
  /// Of each contact in `compliance`: N, or 1 for one without friction, whose tangential reactions are none.
  /// Empty: N of all.
  Array<int> n_rows = {};
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
    AlignedScalars gathered;
  };

  /// Throws InvalidInput if a contact is out of range, has no grain or more than two, or sizes do not fit.
  GrainComplianceDelassus(Index n_contacts, Array<GrainCompliance<N>> grains)
      : places_(n_contacts), diagonal_(n_contacts, Block::Zero()) {
    Index n_values = 0;
    for (Index g = 0; g < grains.size(); ++g) {
      GrainCompliance<N>& grain = grains[g];
      const Index size = grain.contact.size();
      if (grain.n_rows.empty()) grain.n_rows.assign(size, N);
      const Index width = std::accumulate(grain.n_rows.begin(), grain.n_rows.end(), Index{0});
      require(grain.sign.size() == size && grain.n_rows.size() == size && grain.compliance.rows() == width &&
                  grain.compliance.cols() == width && grain.compliance.allFinite(),
              "grain compliance " + std::to_string(g) + ": sizes do not fit or a value is not finite");
      Array<double> sign;  // of each row
      for (Index i = 0; i < size; ++i) sign.insert(sign.end(), std::size_t(grain.n_rows[i]), grain.sign[i]);
      const Index start = n_values, stride = AlignedScalars::padded(width);
      n_values += width * stride;
      values_.resize(n_values);
      n_stored_ += width * width;
      for (Index i = 0; i < width; ++i)
        for (Index j = 0; j < width; ++j)
          values_.data()[start + i * stride + j] = sign[i] * sign[j] * grain.compliance(i, j);
      for (Index i = 0, row = 0; i < size; row += grain.n_rows[i], ++i) {
        const Index c = grain.contact[i];
        const int rows = grain.n_rows[i];
        require(
            c >= 0 && c < n_contacts && places_[c].count < 2,
            "grain compliance " + std::to_string(g) + ": contact out of range or on more than two grains");
        Place& place = places_[c];
        require((rows == 1 || rows == N) && (place.count == 0 || rows == place.n_rows),
                "grain compliance " + std::to_string(g) + ": a contact has 1 or " + std::to_string(N) +
                    " unknowns, the same on both grains");
        place.n_rows = rows;
        place.part[place.count++] = {start + row * stride, n_gathered_, stride, n_gathered_ + row, g};
        for (int k = 0; k < rows; ++k)
          for (int l = 0; l < rows; ++l) diagonal_[c](k, l) += grain.compliance(row + k, row + l);
      }
      n_gathered_ += stride;
      members_.push_back({start, stride, width, std::move(grain.contact)});
    }
    for (Index c = 0; c < n_contacts; ++c) {
      require(places_[c].count > 0, "grain compliances: contact " + std::to_string(c) + " is on no grain");
      for (int i = places_[c].n_rows; i < N; ++i) diagonal_[c](i, i) = diagonal_[c](0, 0);
    }
  }

  Index n_contacts() const { return places_.size(); }
  Index n_stored() const { return n_stored_; }  ///< stored scalars
  Index n_grains() const { return members_.size(); }
  /// That of a contact with one unknown is its W_NN times the identity, so that it is regular.
  const Block& diagonal_block(Index c) const { return diagonal_[c]; }

  /// W_cd.
  Block block(Index c, Index d) const {
    const int n_rows = places_[c].n_rows, n_columns = places_[d].n_rows;
    Block sum = Block::Zero();
    for (int k = 0; k < places_[c].count; ++k)
      for (int l = 0; l < places_[d].count; ++l) {
        const Part& row = places_[c].part[k];
        const Part& column = places_[d].part[l];
        if (row.grain != column.grain) continue;
        const double* const values = values_.data() + row.row + column.own - column.gathered;
        for (int i = 0; i < n_rows; ++i)
          for (int j = 0; j < n_columns; ++j) sum(i, j) += values[i * row.stride + j];
      }
    return sum;
  }

  /// All blocks of W, grain by grain: that of two contacts between the same two grains comes in two parts.
  Array<DelassusBlock<N>> blocks() const {
    Array<DelassusBlock<N>> all;
    for (Index g = 0; g < n_grains(); ++g) {
      const auto c = compliance(g).transpose();
      const Array<Index>& contact = members_[g].contact;
      for (Index i = 0, row = 0; i < contact.size(); row += places_[contact[i++]].n_rows)
        for (Index j = 0, column = 0; j < contact.size(); column += places_[contact[j++]].n_rows) {
          Block block = Block::Zero();
          const int n_rows = places_[contact[i]].n_rows, n_columns = places_[contact[j]].n_rows;
          for (int k = 0; k < n_rows; ++k)
            for (int l = 0; l < n_columns; ++l) block(k, l) = c(row + k, column + l);
          all.push_back({contact[i], contact[j], block});
        }
    }
    return all;
  }

  Motion motion(const Eigen::VectorXd& r) const {
    Motion motion{AlignedScalars(n_gathered_)};
    for (Index c = 0; c < n_contacts(); ++c) change(motion, c, r.template segment<N>(N * c));
    return motion;
  }

  /// Of a contact with one unknown only the normal velocity is other than zero.
  [[gnu::always_inline]] ContactVector<N> velocity(const Motion& motion, const Eigen::VectorXd&,
                                                   Index c) const {
    const Place& place = places_[c];
    if (place.n_rows == N) return row_sums<N>(place, motion);
    ContactVector<N> u = ContactVector<N>::Zero();
    u[0] = row_sums<1>(place, motion)[0];
    return u;
  }

  [[gnu::always_inline]] void change(Motion& motion, Index c, const ContactVector<N>& dr) const {
    const Place& place = places_[c];
    for (int k = 0; k < place.count; ++k) {
      double* const own = motion.gathered.data() + place.part[k].own;
      if (place.n_rows == N)
        Eigen::Map<ContactVector<N>>(own) += dr;
      else
        own[0] += dr[0];
    }
  }

  /// Visits the one or two grains of contact c.
  template <class Visit>
  void for_each_body(Index c, Visit visit) const {
    for (int k = 0; k < places_[c].count; ++k) visit(places_[c].part[k].grain);
  }

  /// visit(grain, row) for the one or two grains of contact c, `row` the first of its n_rows(c) rows of C.
  template <class Visit>
  void for_each_place(Index c, Visit visit) const {
    for (int k = 0; k < places_[c].count; ++k) {
      const Part& part = places_[c].part[k];
      visit(part.grain, part.own - part.gathered);
    }
  }
  /// Unknowns of contact c that W knows: N, or 1.
  int n_rows(Index c) const { return places_[c].n_rows; }

  /// C of a grain, the signs of its contacts taken in; its columns are the rows stored (it is symmetric).
  Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>> compliance(Index grain) const {
    const Members& members = members_[grain];
    return {values_.data() + members.start, members.width, members.width,
            Eigen::OuterStride<>(members.stride)};
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
    Index row;       // first value of the contact's rows
    Index gathered;  // the grain's gathered reactions
    Index stride;    // from row to row: their length, padded with zeros
    Index own;       // the contact's own place among all gathered reactions
    Index grain;
  };
  struct Place {
    int count = 0, n_rows = N;
    Part part[2];
  };
  struct Members {
    Index start;   // of the grain's C among all values
    Index stride;  // from row to row
    Index width;   // of C
    Array<Index> contact;
  };

  template <int M>
  [[gnu::always_inline]] ContactVector<M> row_sums(const Place& place, const Motion& motion) const {
    RowSums<M> sums;
    for (int k = 0; k < place.count; ++k) {
      const Part& part = place.part[k];
      sums.template add<true>(values_.data() + part.row, part.stride, part.stride,
                              motion.gathered.data() + part.gathered);
    }
    return sums.sums();
  }

  Array<Place> places_;
  Array<Members> members_;
  AlignedScalars values_;
  Array<Block> diagonal_;
  Index n_gathered_ = 0, n_stored_ = 0;
  std::function<void(const Eigen::VectorXd&, Eigen::VectorXd&)> product_;
};

static_assert(DelassusOperator<GrainComplianceDelassus<3>>);

}  // namespace jampack
