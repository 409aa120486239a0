// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Dense>
#include <jampack/core/array.hpp>

namespace jampack {

/// Anderson's acceleration of a fixed-point iteration x <- x + f(x): the next point is the combination of the
/// last ones that makes the combined f least (D. G. Anderson, J. ACM 12 (1965) 547; Walker and Ni, SIAM J.
/// Numer. Anal. 49 (2011) 1715). What converges slowly along few directions converges as GMRES would.
class Anderson {
 public:
  Index depth = 6;            ///< how many differences are kept, > 0
  double largest_growth = 2;  ///< |f| may grow by this before the past is forgotten

  void forget() { differences_.clear(), has_last_ = false; }

  /// Takes x and f(x); returns the step from x to the next point (f itself where there is no past).
  Eigen::VectorXd step(const Eigen::VectorXd& x, const Eigen::VectorXd& f) {
    if (has_last_ && (x.size() != last_x_.size() || f.norm() > largest_growth * last_f_.norm())) forget();
    if (has_last_) {
      differences_.push_back({x - last_x_, f - last_f_});
      if (differences_.size() > depth) differences_.erase(differences_.begin());
    }
    last_x_ = x;
    last_f_ = f;
    has_last_ = true;
    const Index m = differences_.size();
    if (m == 0) return f;
    Eigen::MatrixXd df(f.size(), m);
    for (Index k = 0; k < m; ++k) df.col(k) = differences_[k].f / differences_[k].f.norm();
    const Eigen::VectorXd weight = df.colPivHouseholderQr().solve(f);
    if (!weight.allFinite()) return f;
    Eigen::VectorXd next = f;
    for (Index k = 0; k < m; ++k)
      next -= weight[k] / differences_[k].f.norm() * (differences_[k].x + differences_[k].f);
    return next;
  }

 private:
  struct Difference {
    Eigen::VectorXd x, f;
  };
  Array<Difference> differences_;
  Eigen::VectorXd last_x_, last_f_;
  bool has_last_ = false;
};

}  // namespace jampack
