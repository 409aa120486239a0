// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Cholesky>
#include <jampack/body/cholesky_structure.hpp>
#include <memory>
#include <type_traits>

namespace jampack {

/// Supernodal Cholesky factorisation P A P^T = L L^T of a symmetric positive definite BlockMatrix. Of each
/// supernode, with L11 and L21 its columns of L, it keeps the trapezoid [L11^-1; -L21 L11^-1], so that either
/// sweep of a solve is one dense product a supernode, without a recurrence.
///
/// `Stored` is what the factor is kept in, and what the sweeps of solve() and backward() work in. Many
/// grains' factors outgrow the caches, and a solve takes as long as reading one. float halves that and serves
/// a preconditioner, unless the condition nears 1e7: then nothing of the solution is right.
template <int Dim, class Stored = double>
class BlockCholesky {
 public:
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  void analyse(const BlockPattern& pattern) { analyse(std::make_shared<const CholeskyStructure>(pattern)); }
  /// The structure may be shared with other matrices of the pattern.
  void analyse(std::shared_ptr<const CholeskyStructure> structure) {
    structure_ = std::move(structure);
    panels_.clear();
    front_size_ = highest_ = 0;
    Index size = 0;
    for (const auto& s : structure_->supernodes) {
      const Index w = Dim * s.n_pivots, height = padded(w + Dim * s.n_rows);
      panels_.push_back({size, front_size_, height, w});
      for (Index j = 0; j < w; j += slice) size += std::min(slice, w - j) * (height - down(j));
      front_size_ += w * height;
      highest_ = std::max(highest_, height);
    }
    value_.setZero(size);
  }

  /// Factorises; false when the matrix is not positive definite or not finite (nothing usable is left then).
  bool factorise(const BlockMatrix<Dim>& matrix) {
    double* front = room(workspace().front, front_size_);
    std::fill_n(front, front_size_, 0.0);
    for (const auto& e : structure_->entries) {
      const auto& p = panels_[e.supernode];
      Strided<Dim, Dim>(front + p.front + Dim * (e.column * p.height + e.row), Dim, Dim,
                        Eigen::OuterStride<>(p.height)) = matrix.block[e.block];
    }
    for (Index s = 0; s < panels_.size(); ++s)
      if (!eliminate(s, front)) return false;
    return true;
  }

  Index n_stored() const { return value_.size(); }  ///< numbers that solve() reads, twice

  /// A^-1 b.
  Eigen::VectorXd solve(const Eigen::Ref<const Eigen::VectorXd>& b) const {
    const auto& order = structure_->order;
    Stored* y = room(work_of_sweeps().ordered, Dim * order.size());
    const double scale = unit(b);
    for (Index k = 0; k < order.size(); ++k)
      Nodal(y + Dim * k) = (b.template segment<Dim>(Dim * order[k]) / scale).template cast<Stored>();
    for (Index s = 0; s < panels_.size(); ++s) sweep_up(s, y);
    for (Index s = panels_.size() - 1; s >= 0; --s) sweep_down(s, y);
    Eigen::VectorXd x(b.size());
    restore_order(y, scale, x);
    return x;
  }

  /// b becomes L^-1 P b. One row of b a degree of freedom, so that all its columns are worked on at once.
  void forward(RowMajor& b) const {
    const auto& order = structure_->order;
    auto& work = workspace();
    const Index n = b.cols();
    Eigen::Map<RowMajor> y(room(work.columns, b.size()), b.rows(), n);
    for (Index k = 0; k < order.size(); ++k)
      y.template middleRows<Dim>(Dim * k) = b.template middleRows<Dim>(Dim * order[k]);
    for (Index s = 0; s < panels_.size(); ++s) {
      const auto& node = structure_->supernodes[s];
      const Index r = Dim * node.n_rows, w = panels_[s].width;
      const Strided<> panel(unpack(s), w + r, w, Eigen::OuterStride<>(panels_[s].height));
      Eigen::Map<RowMajor> product(room(work.product, (w + r) * n), w + r, n);
      product.noalias() = panel * y.middleRows(Dim * node.first, w);
      b.middleRows(Dim * node.first, w) = product.topRows(w);
      const auto* row = structure_->rows.data() + node.row_start;
      for (Index i = 0; i < node.n_rows; ++i)
        y.template middleRows<Dim>(Dim * row[i]) += product.template middleRows<Dim>(w + Dim * i);
    }
  }

  /// y becomes P^T L^-T y.
  void backward(Eigen::VectorXd& y) const {
    Stored* x = room(work_of_sweeps().ordered, y.size());
    const double scale = unit(y);
    Eigen::Map<StoredVector>(x, y.size()) = (y / scale).template cast<Stored>();
    for (Index s = panels_.size() - 1; s >= 0; --s) sweep_down(s, x);
    restore_order(x, scale, y);
  }

 private:
  template <int Rows = Eigen::Dynamic, int Columns = Eigen::Dynamic, class Scalar = double>
  using Strided = Eigen::Map<Eigen::Matrix<Scalar, Rows, Columns>, 0, Eigen::OuterStride<>>;
  using StoredVector = Eigen::Matrix<Stored, Eigen::Dynamic, 1>;
  using Nodal = Eigen::Map<Eigen::Matrix<Stored, Dim, 1>>;

  /// A panel is kept in slices of that many columns, each without the rows, in whole packets, that are zero
  /// in all of its columns (half of what stands above the diagonal takes no memory); a slice is kept in tiles
  /// of one packet of rows, column-major, so that a sweep reads memory from one end to the other.
  static constexpr Index slice = 6;
  static constexpr int packet = 8;
  static constexpr Index down(Index n) { return n / packet * packet; }
  static constexpr Index padded(Index n) { return down(n + packet - 1); }
  using Packet = Eigen::Array<Stored, packet, 1>;
  using Tile = Eigen::Map<Eigen::Matrix<Stored, packet, Eigen::Dynamic>>;
  using ConstTile = Eigen::Map<const Eigen::Matrix<Stored, packet, Eigen::Dynamic>>;
  static constexpr int alignment = std::min<int>(EIGEN_MAX_ALIGN_BYTES, packet * sizeof(Stored));

  static Eigen::Map<Packet, alignment> packet_at(Stored* p) { return Eigen::Map<Packet, alignment>(p); }
  static Eigen::Map<const Packet, alignment> packet_at(const Stored* p) {
    return Eigen::Map<const Packet, alignment>(p);
  }

  struct Panel {
    Index start;          ///< in value_
    Index front;          ///< in the workspace of factorise, columns of `height`
    Index height, width;  ///< rows, padded; columns
  };

  /// Shared by all factors a thread works with.
  struct Workspace {
    Eigen::VectorXd front, inverse, lower, update, panel, columns, product;
  };
  struct WorkOfSweeps {
    StoredVector ordered, rows;
  };
  static Workspace& workspace() {
    static thread_local Workspace work;
    return work;
  }
  static WorkOfSweeps& work_of_sweeps() {
    static thread_local WorkOfSweeps work;
    return work;
  }
  /// Memory for n numbers; a workspace never shrinks.
  template <class Storage>
  static auto* room(Storage& storage, Index n) {
    if (storage.size() < n) storage.resize(n);
    return storage.data();
  }

  /// What to divide by so that the range of floats does not matter.
  static double unit(const Eigen::Ref<const Eigen::VectorXd>& b) {
    if constexpr (std::is_same_v<Stored, double>) return 1;
    const double largest = b.template lpNorm<Eigen::Infinity>();
    return largest > 0 ? largest : 1;
  }

  void restore_order(const Stored* y, double scale, Eigen::VectorXd& x) const {
    const auto& order = structure_->order;
    for (Index k = 0; k < order.size(); ++k)
      x.template segment<Dim>(Dim * order[k]) =
          scale * Eigen::Map<const Eigen::Matrix<Stored, Dim, 1>>(y + Dim * k).template cast<double>();
  }

  /// Calls work(first column, number of columns, first row, number of rows, first value) slice by slice.
  template <class Work>
  void for_slices(Index s, Work&& work) const {
    const auto& p = panels_[s];
    Index at = p.start;
    for (Index j = 0; j < p.width; j += slice) {
      const Index n = std::min(slice, p.width - j), first = down(j), height = p.height - first;
      work(j, n, first, height, at);
      at += n * height;
    }
  }

  /// Calls work with 0, ..., n - 1 as a sequence, n being the columns of a slice: `slice` or fewer nodes'.
  template <class Work>
  static void with_columns(Index n, Work&& work) {
    if (n == slice) return work(std::make_integer_sequence<int, slice>());
    if (n == Dim) return work(std::make_integer_sequence<int, Dim>());
    if constexpr (2 * Dim < slice) work(std::make_integer_sequence<int, 2 * Dim>());
  }

  /// t += a b, with a a slice.
  template <int... C>
  static void multiply(std::integer_sequence<int, C...>, const Stored* a, Index height, const Stored* b,
                       Stored* t) {
    for (const Stored* end = t + height; t != end; t += packet, a += packet * sizeof...(C)) {
      auto sum = packet_at(t);
      sum = (sum + ... + (b[C] * packet_at(a + C * packet)));
    }
  }
  /// Eigen's own sum of a packet makes GCC 12 warn of its AVX-512 intrinsics.
  static Stored add_up(const Stored* p) {
    static_assert(packet == 8);
    return ((p[0] + p[4]) + (p[2] + p[6])) + ((p[1] + p[5]) + (p[3] + p[7]));
  }
  /// x = a^T t, with a a slice.
  template <int... C>
  static void multiply_transposed(std::integer_sequence<int, C...>, const Stored* a, Index height,
                                  const Stored* t, Stored* x) {
    Packet sum[sizeof...(C)];
    ((sum[C] = Packet::Zero()), ...);
    for (const Stored* end = t + height; t != end; t += packet, a += packet * sizeof...(C)) {
      const Packet rows = packet_at(t);
      ((sum[C] += rows * packet_at(a + C * packet)), ...);
    }
    ((x[C] = add_up(sum[C].data())), ...);
  }

  void sweep_up(Index s, Stored* y) const {
    const auto& node = structure_->supernodes[s];
    const auto& p = panels_[s];
    Stored* t = room(work_of_sweeps().rows, highest_);
    Stored* pivots = y + Dim * node.first;
    std::fill_n(t, p.height, Stored(0));
    for_slices(s, [&](Index j, Index n, Index first, Index height, Index at) {
      with_columns(
          n, [&](auto columns) { multiply(columns, value_.data() + at, height, pivots + j, t + first); });
    });
    std::copy_n(t, p.width, pivots);
    const auto* row = structure_->rows.data() + node.row_start;
    for (Index i = 0; i < node.n_rows; ++i) Nodal(y + Dim * row[i]) += Nodal(t + p.width + Dim * i);
  }

  void sweep_down(Index s, Stored* y) const {
    const auto& node = structure_->supernodes[s];
    const auto& p = panels_[s];
    Stored* t = room(work_of_sweeps().rows, highest_);
    Stored* pivots = y + Dim * node.first;
    std::fill_n(t + p.height - packet, packet, Stored(0));  // the padding
    std::copy_n(pivots, p.width, t);
    const auto* row = structure_->rows.data() + node.row_start;
    for (Index i = 0; i < node.n_rows; ++i) Nodal(t + p.width + Dim * i) = Nodal(y + Dim * row[i]);
    for_slices(s, [&](Index j, Index n, Index first, Index height, Index at) {
      with_columns(n, [&](auto columns) {
        multiply_transposed(columns, value_.data() + at, height, t + first, pivots + j);
      });
    });
  }

  /// The panel in plain columns, padded likewise, in the workspace.
  double* unpack(Index s) const {
    const Index stride = panels_[s].height;
    double* panel = room(workspace().panel, stride * panels_[s].width);
    for_slices(s, [&](Index j, Index n, Index first, Index height, Index at) {
      double* column = panel + j * stride;
      Strided<>(column, first, n, Eigen::OuterStride<>(stride)).setZero();
      for (Index i = 0; i < height; i += packet)
        Strided<packet>(column + first + i, packet, n, Eigen::OuterStride<>(stride)) =
            ConstTile(value_.data() + at + i * n, packet, n).template cast<double>();
    });
    return panel;
  }
  void pack(Index s, double* panel) {
    const Index stride = panels_[s].height;
    for_slices(s, [&](Index j, Index n, Index first, Index height, Index at) {
      for (Index i = 0; i < height; i += packet)
        Tile(value_.data() + at + i * n, packet, n) =
            Strided<packet>(panel + j * stride + first + i, packet, n, Eigen::OuterStride<>(stride))
                .template cast<Stored>();
    });
  }

  /// Turns the assembled panel into its part of the factor and subtracts from the later ones.
  bool eliminate(Index s, double* front) {
    const auto& p = panels_[s];
    const Index r = Dim * structure_->supernodes[s].n_rows, w = p.width;
    auto& work = workspace();
    Strided<> pivot(front + p.front, w, w, Eigen::OuterStride<>(p.height));
    Strided<> below(front + p.front + w, r, w, Eigen::OuterStride<>(p.height));

    Eigen::Ref<Eigen::MatrixXd> pivot_in_place(pivot);
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> cholesky(pivot_in_place);
    if (cholesky.info() != Eigen::Success) return false;
    // Eigen's does not see that a pivot is not a number.
    const auto diagonal = pivot.diagonal().array();
    if (!(diagonal > 0 && diagonal <= std::numeric_limits<double>::max()).all()) return false;
    Eigen::Map<Eigen::MatrixXd> inverse(room(work.inverse, w * w), w, w);
    inverse.setIdentity();
    pivot.template triangularView<Eigen::Lower>().solveInPlace(inverse);
    pivot = inverse;
    if (r > 0) {
      Eigen::Map<Eigen::MatrixXd> lower(room(work.lower, r * w), r, w);
      Eigen::Map<Eigen::MatrixXd> update(room(work.update, r * r), r, r);
      lower.noalias() = below * inverse.transpose();
      update.template triangularView<Eigen::Lower>() = lower * lower.transpose();
      below.noalias() = -lower * inverse;
      scatter(s, update, front);
    }
    pack(s, front + p.front);
    return true;
  }

  void scatter(Index s, const Eigen::Map<Eigen::MatrixXd>& update, double* front) const {
    const auto& node = structure_->supernodes[s];
    const auto* row = structure_->rows.data() + node.row_start;
    for (Index u = node.update_start; u < node.update_end; ++u) {
      const auto& to = structure_->updates[u];
      const auto& p = panels_[to.target];
      const auto* place = structure_->place.data() + to.place_start;
      for (Index j = to.begin; j < to.end; ++j) {
        double* column =
            front + p.front + Dim * (row[j] - structure_->supernodes[to.target].first) * p.height;
        for (Index c = 0; c < Dim; ++c, column += p.height) {
          const double* from = update.data() + (Dim * j + c) * update.rows();
          for (Index i = j; i < node.n_rows; ++i)
            Eigen::Map<Vector<Dim>>(column + Dim * place[i - to.begin]) -=
                Eigen::Map<const Vector<Dim>>(from + Dim * i);
        }
      }
    }
  }

  std::shared_ptr<const CholeskyStructure> structure_;
  Array<Panel> panels_;
  Index front_size_ = 0, highest_ = 0;
  StoredVector value_;
};

}  // namespace jampack
