// SPDX-License-Identifier: MIT
#pragma once

// Needs HDF5 (C library); everything else of jampack does without.
#include <hdf5.h>

#include <Eigen/SparseCore>
#include <Eigen/SparseLU>
#include <array>
#include <filesystem>
#include <jampack/io/contact_problem_text.hpp>
#include <string>
#include <utility>
#include <vector>

namespace jampack {

namespace detail {

/// An open HDF5 object, closed at the end of its scope. HDF5's own messages are silenced while one lives.
class Hdf5Handle {
 public:
  Hdf5Handle(hid_t id, herr_t (*close)(hid_t), const std::string& what) : id_(id), close_(close) {
    require(id >= 0, what);
  }
  Hdf5Handle(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(const Hdf5Handle&) = delete;
  ~Hdf5Handle() { close_(id_); }
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

class Hdf5Reader {
 public:
  explicit Hdf5Reader(const std::filesystem::path& path)
      : name_(path.string()), file_(open(path), H5Fclose, name_ + ": no HDF5 file that can be read") {}

  bool has(const std::string& path) const {
    // Every group on the way must exist before its member may be asked for.
    for (std::size_t slash = path.find('/', 1);; slash = path.find('/', slash + 1)) {
      if (H5Lexists(file_, path.substr(0, slash).c_str(), H5P_DEFAULT) <= 0) return false;
      if (slash == std::string::npos) return true;
    }
  }
  template <class T>
  Array<T> read(const std::string& path) const {
    require(has(path), name_ + ": " + path + " is missing");
    const Hdf5Handle set(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose, name_ + ": " + path);
    const Hdf5Handle space(H5Dget_space(set), H5Sclose, name_ + ": " + path);
    Array<T> values(static_cast<Index>(H5Sget_simple_extent_npoints(space)));
    const hid_t type = std::is_same_v<T, int> ? H5T_NATIVE_INT : H5T_NATIVE_DOUBLE;
    require(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0,
            name_ + ": " + path + " cannot be read");
    return values;
  }
  Eigen::VectorXd vector(const std::string& path) const {
    const Array<double> values = read<double>(path);
    return Eigen::Map<const Eigen::VectorXd>(values.data(), values.size());
  }
  Index integer(const std::string& path) const {
    const Array<int> values = read<int>(path);
    require(values.size() >= 1, name_ + ": " + path + " is empty");
    return values[0];
  }
  /// A CSparse matrix: nz = -1 compressed columns, -2 compressed rows, >= 0 triplets.
  Eigen::SparseMatrix<double> matrix(const std::string& path) const {
    const Index rows = integer(path + "/m"), columns = integer(path + "/n"), nz = integer(path + "/nz");
    const Array<int> p = read<int>(path + "/p"), i = read<int>(path + "/i");
    const Array<double> x = read<double>(path + "/x");
    const std::string broken = name_ + ": " + path + " is not a sparse matrix";
    require(rows >= 0 && columns >= 0 && nz >= -2, broken);
    std::vector<Eigen::Triplet<double, Index>> entries;
    const auto add = [&](Index row, Index column, double value) {
      require(row >= 0 && row < rows && column >= 0 && column < columns, broken);
      entries.emplace_back(row, column, value);
    };
    if (nz >= 0) {
      require(p.size() >= nz && i.size() >= nz && x.size() >= nz, broken);
      // Triplets: CSparse's p are columns and i rows.
      for (Index k = 0; k < nz; ++k) add(i[k], p[k], x[k]);
    } else {
      const Index outer = nz == -1 ? columns : rows;
      require(p.size() > outer && p[0] == 0 && p[outer] <= i.size() && p[outer] <= x.size(), broken);
      for (Index k = 0; k < outer; ++k) {
        require(p[k] <= p[k + 1], broken);
        for (Index entry = p[k]; entry < p[k + 1]; ++entry)
          nz == -1 ? add(i[entry], k, x[entry]) : add(k, i[entry], x[entry]);
      }
    }
    Eigen::SparseMatrix<double> matrix(rows, columns);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
  }
  const std::string& name() const { return name_; }

 private:
  static hid_t open(const std::filesystem::path& path) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    return H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  }
  std::string name_;
  Hdf5Handle file_;
};

template <int N>
StoredContactProblem<N> stored_problem(const Eigen::SparseMatrix<double>& w, Eigen::VectorXd q,
                                       const Eigen::VectorXd& friction, const std::string& name) {
  const Index n = friction.size();
  require(w.rows() == N * n && w.cols() == N * n && q.size() == N * n,
          name + ": sizes of W, q and mu do not fit each other");
  Array<DelassusBlock<N>> blocks;
  Array<Index> block_of_row(n, Index{-1});
  for (Index d = 0; d < n; ++d) {  // the scalar columns of one contact together
    const Index first = blocks.size();
    for (int j = 0; j < N; ++j)
      for (Eigen::SparseMatrix<double>::InnerIterator entry(w, N * d + j); entry; ++entry) {
        const Index c = entry.row() / N;
        if (block_of_row[c] < first) {
          block_of_row[c] = blocks.size();
          blocks.push_back({c, d, Eigen::Matrix<double, N, N>::Zero()});
        }
        blocks[block_of_row[c]].value(entry.row() % N, j) = entry.value();
      }
  }
  Array<typename StoredContactProblem<N>::LocalLaw> law(n);
  if constexpr (N > 1)
    for (Index c = 0; c < n; ++c) law[c].friction = friction[c];
  return {BlockSparseDelassus<N>(n, std::move(blocks)), std::move(q), std::move(law)};
}

/// W = H^T S H, q = H^T S f + w with S the inverse of M, or of M under the bilateral constraints
/// G^T v + b = 0 (docs/theory/contact_solvers.md, eq. 10).
inline void condense(const Hdf5Reader& file, Eigen::SparseMatrix<double>& w, Eigen::VectorXd& q) {
  const std::string root = "/fclib_global";
  const Eigen::SparseMatrix<double> m = file.matrix(root + "/M"), h = file.matrix(root + "/H");
  Eigen::VectorXd f = file.vector(root + "/vectors/f");
  q = file.vector(root + "/vectors/w");
  Eigen::SparseMatrix<double> g(m.rows(), 0);
  Eigen::VectorXd b;
  if (file.has(root + "/G")) {
    g = file.matrix(root + "/G");
    if (g.cols() > 0) b = file.vector(root + "/vectors/b");
  }
  require(m.rows() == m.cols() && h.rows() == m.rows() && f.size() == m.rows() && g.rows() == m.rows() &&
              q.size() == h.cols() && b.size() == g.cols(),
          file.name() + ": sizes of M, H, G, f, w and b do not fit each other");
  std::vector<Eigen::Triplet<double>> entries;
  const int n = static_cast<int>(m.rows()), k = static_cast<int>(g.cols());
  for (int j = 0; j < n; ++j)
    for (Eigen::SparseMatrix<double>::InnerIterator e(m, j); e; ++e)
      entries.emplace_back(static_cast<int>(e.row()), j, e.value());
  for (int j = 0; j < k; ++j)
    for (Eigen::SparseMatrix<double>::InnerIterator e(g, j); e; ++e) {
      entries.emplace_back(static_cast<int>(e.row()), n + j, -e.value());
      entries.emplace_back(n + j, static_cast<int>(e.row()), e.value());
    }
  Eigen::SparseMatrix<double> saddle(n + k, n + k);
  saddle.setFromTriplets(entries.begin(), entries.end());
  Eigen::SparseLU<Eigen::SparseMatrix<double>> lu(saddle);
  require(lu.info() == Eigen::Success, file.name() + ": the mass matrix (with its constraints) is singular");
  Eigen::VectorXd load(n + k);
  load << f, -b;
  q += h.transpose() * Eigen::VectorXd(lu.solve(load)).head(n);
  std::vector<Eigen::Triplet<double>> w_entries;
  Eigen::VectorXd column = Eigen::VectorXd::Zero(n + k);
  for (int j = 0; j < h.cols(); ++j) {
    column.setZero();
    for (Eigen::SparseMatrix<double>::InnerIterator e(h, j); e; ++e) column[e.row()] = e.value();
    const Eigen::VectorXd velocity = h.transpose() * Eigen::VectorXd(lu.solve(column)).head(n);
    for (int i = 0; i < velocity.size(); ++i)
      if (velocity[i] != 0) w_entries.emplace_back(i, j, velocity[i]);
  }
  w.resize(h.cols(), h.cols());
  w.setFromTriplets(w_entries.begin(), w_entries.end());
}

}  // namespace detail

/// Reads a frictional contact problem of the FCLIB collection, 2D or 3D: a Local one (u = W r + q), or a
/// Global one (M v = H r + f, u = H^T v + w), which is condensed. Throws InvalidInput with what is wrong.
inline AnyContactProblem read_fclib(const std::filesystem::path& path) {
  const detail::Hdf5Reader file(path);
  const bool is_local = file.has("/fclib_local/W");
  require(is_local || file.has("/fclib_global/M"), file.name() + ": no FCLIB problem inside");
  const std::string root = is_local ? "/fclib_local" : "/fclib_global";
  const Index dimension = file.integer(root + "/spacedim");
  require(dimension == 2 || dimension == 3, file.name() + ": spacedim must be 2 or 3");
  require(!is_local || !file.has(root + "/R"),
          file.name() + ": equality constraints (R, V) are not supported");
  const Eigen::VectorXd friction = file.vector(root + "/vectors/mu");
  Eigen::SparseMatrix<double> w;
  Eigen::VectorXd q;
  if (is_local) {
    w = file.matrix(root + "/W");
    q = file.vector(root + "/vectors/q");
  } else {
    detail::condense(file, w, q);
  }
  if (dimension == 2) return detail::stored_problem<2>(w, std::move(q), friction, file.name());
  return detail::stored_problem<3>(w, std::move(q), friction, file.name());
}

/// Writes a problem as an FCLIB Local file (W by rows, nz = -2). Frictionless problems (one unknown) and
/// compliant laws have no place in that format. Throws Error if the file cannot be written.
template <class Problem>
void write_fclib(const std::filesystem::path& path, const Problem& problem,
                 const std::string& description = "contact problem") {
  constexpr int N = Problem::n_unknowns;
  static_assert(N > 1 && !Problem::LocalLaw::is_compliant,
                "FCLIB holds frictional rigid contacts of 2 or 3 unknowns");
  const Index n = problem.n_contacts();
  Eigen::SparseMatrix<double, Eigen::RowMajor> w(N * n, N * n);
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& block : stored_blocks(problem.delassus))
    for (int i = 0; i < N; ++i)
      for (int j = 0; j < N; ++j)
        entries.emplace_back(static_cast<int>(N * block.row + i), static_cast<int>(N * block.column + j),
                             block.value(i, j));
  w.setFromTriplets(entries.begin(), entries.end());
  w.makeCompressed();

  const std::string failure = "cannot write " + path.string();
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const detail::Hdf5Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose,
                                failure);
  const auto group = [&](const char* name) {
    detail::Hdf5Handle(H5Gcreate2(file, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose, failure);
  };
  const auto set = [&](const std::string& name, hid_t type, Index size, const void* values) {
    const hsize_t extent = static_cast<hsize_t>(size);
    const detail::Hdf5Handle space(H5Screate_simple(1, &extent, nullptr), H5Sclose, failure);
    const detail::Hdf5Handle data(
        H5Dcreate2(file, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Dclose,
        failure);
    if (H5Dwrite(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) throw Error(failure);
  };
  const auto integer = [&](const std::string& name, Index value) {
    const int as_int = static_cast<int>(value);
    set(name, H5T_NATIVE_INT, 1, &as_int);
  };
  for (const char* name : {"/fclib_local", "/fclib_local/W", "/fclib_local/vectors", "/fclib_local/info"})
    group(name);
  integer("/fclib_local/spacedim", N);
  integer("/fclib_local/W/nzmax", w.nonZeros());
  integer("/fclib_local/W/m", w.rows());
  integer("/fclib_local/W/n", w.cols());
  integer("/fclib_local/W/nz", -2);
  set("/fclib_local/W/p", H5T_NATIVE_INT, w.rows() + 1, w.outerIndexPtr());
  set("/fclib_local/W/i", H5T_NATIVE_INT, w.nonZeros(), w.innerIndexPtr());
  set("/fclib_local/W/x", H5T_NATIVE_DOUBLE, w.nonZeros(), w.valuePtr());
  Array<double> friction(n);
  for (Index c = 0; c < n; ++c) friction[c] = problem.law[c].friction;
  set("/fclib_local/vectors/mu", H5T_NATIVE_DOUBLE, n, friction.data());
  set("/fclib_local/vectors/q", H5T_NATIVE_DOUBLE, problem.free_velocity.size(),
      problem.free_velocity.data());
  const detail::Hdf5Handle text(H5Tcopy(H5T_C_S1), H5Tclose, failure);
  H5Tset_size(text, description.size() + 1);
  for (const char* name :
       {"/fclib_local/info/title", "/fclib_local/info/description", "/fclib_local/info/math_info"})
    set(name, text, 1, description.c_str());
}

}  // namespace jampack
