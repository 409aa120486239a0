// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <jampack/problem/residual.hpp>
#include <jampack/solver/slip_direction.hpp>
#include <limits>

namespace jampack {

/// Exact solution of one contact, u = W r + b with the law between r and u, everything else held fixed. It
/// cannot stick: the states open, sticking and slipping are enumerated, slip by all roots of its equation
/// (docs/theory/contact_solvers.md, section 4). Made once a contact for its block W = W_cc.
///
/// A block that is singular (or not positive) is solved by proximal steps around the present reaction, whose
/// fixed points are solutions of the unchanged problem.
template <int N, class Block = Eigen::Matrix<double, N, N>>
class LocalSolver {
  using Matrix = Eigen::Matrix<double, N, N>;
  using Reaction = ContactVector<N>;

 public:
  LocalSolver() = default;
  explicit LocalSolver(const Block& block) : w_(block) {
    const double trace = block.trace();
    if (!(trace > 0)) return;
    const Matrix scaled = block / trace;
    // Twice the symmetric part bounds how far W is from losing positivity.
    const double smallest = smallest_eigenvalue(0.5 * (scaled + scaled.transpose()));
    if (smallest < 1e-10) proximal_ = trace * (1e-7 + std::max(0.0, -2 * smallest));
    shifted_ = w_ + proximal_ * Matrix::Identity();
    inverse_ = (shifted_ / trace).inverse() / trace;
    solvable_ = inverse_.allFinite();
  }

  /// The reaction that satisfies the law; `velocity` is u at the present reaction `r`. Where the block is
  /// zero the reaction can change nothing and stays.
  template <LocalContactLaw Law>
  Reaction solve(const Law& law, const Reaction& velocity, const Reaction& r) const {
    if (!solvable_) return velocity[0] > 0 ? Reaction(Reaction::Zero()) : r;
    if (proximal_ == 0) return solve_regular(law, Reaction(velocity - w_ * r), r);
    const Reaction b = velocity - w_ * r;
    Reaction iterate = r;
    for (int k = 0; k < 20; ++k) {
      const Reaction next = solve_regular(law, Reaction(b - proximal_ * iterate), iterate);
      const double change = (next - iterate).norm();
      iterate = next;
      if (change <= 1e-14 * iterate.norm()) break;
    }
    return iterate;
  }

 private:
  template <LocalContactLaw Law>
  Reaction solve_regular(const Law& law, const Reaction& b, const Reaction& guess) const {
    if constexpr (!Law::is_compliant) {
      return solve_rigid(shifted_, inverse_, law.friction, b, guess);
    } else {
      return solve_compliant(law, b, guess);
    }
  }

  static Reaction solve_rigid(const Matrix& w, const Matrix& inverse, double friction, const Reaction& b,
                              const Reaction& guess) {
    if (b[0] >= 0) return Reaction::Zero();
    if constexpr (N == 1) {
      return Reaction(-b[0] / w(0, 0));
    } else {
      const Reaction stick = -(inverse * b);
      if (in_friction_cone<N>(stick, friction)) return stick;
      return slip(w, friction, b, guess, stick);
    }
  }

  static Reaction slip(const Matrix& w, double friction, const Reaction& b, const Reaction& guess,
                       const Reaction& stick) {
    if constexpr (N == 2) {
      // Two directions; where rounding rejects both, the one that errs less.
      Reaction best = Reaction::Zero();
      double best_error = std::numeric_limits<double>::infinity();
      for (const double d : {stick[1] > 0 ? -1.0 : 1.0, stick[1] > 0 ? 1.0 : -1.0}) {
        const double stiffness = w(0, 0) - friction * d * w(0, 1);
        if (!(stiffness > 0)) continue;
        const double normal = -b[0] / stiffness;
        const Reaction r(normal, -friction * d * normal);
        const double sliding = d * (w(1, 0) * r[0] + w(1, 1) * r[1] + b[1]);
        if (sliding >= 0) return r;
        if (-sliding < best_error) {
          best_error = -sliding;
          best = r;
        }
      }
      return best;
    } else {
      if (friction == 0) return Reaction(-b[0] / w(0, 0), 0, 0);
      const SlipEquation equation(w, b, friction);
      Eigen::Vector2d d = -guess.template tail<2>();
      if (!(d.squaredNorm() > 0)) d = -stick.template tail<2>();
      if (d.squaredNorm() > 0) {
        d.normalize();
        if (equation.follow(d[0], d[1])) return slipping(equation, friction, b[0], d);
      }
      return best_of_all(equation, w, friction, b, stick);
    }
  }

  static Reaction slipping(const SlipEquation& equation, double friction, double b_n,
                           const Eigen::Vector2d& d) {
    const double normal = -b_n / equation.normal_stiffness(d[0], d[1]);
    return Reaction(normal, -friction * normal * d[0], -friction * normal * d[1]);
  }

  // Every state that can be a solution, judged by the natural map.
  static Reaction best_of_all(const SlipEquation& equation, const Matrix& w, double friction,
                              const Reaction& b, const Reaction& stick) {
    const double rho = N / w.trace();
    const SignoriniCoulomb law{friction};
    Reaction best = Reaction::Zero();
    double best_error = natural_map<N>(law, best, b, rho).squaredNorm();
    const auto judge = [&](const Reaction& r) {
      const double error = natural_map<N>(law, r, Reaction(w * r + b), rho).squaredNorm();
      if (error < best_error) {
        best_error = error;
        best = r;
      }
    };
    judge(project_on_friction_cone<N>(stick, friction));
    std::array<Eigen::Vector2d, 14> directions;
    const int n = equation.candidates(directions);
    for (int i = 0; i < n; ++i) {
      const Eigen::Vector2d& d = directions[static_cast<std::size_t>(i)];
      if (equation.normal_stiffness(d[0], d[1]) > 0) judge(slipping(equation, friction, b[0], d));
    }
    return best;
  }

  // Newton's method on the compliance, tangent by tangent; each one is a rigid problem with a softer W_NN. It
  // starts from the reaction that is too large (no other compliance acts), from where the iteration of the
  // frictionless problem is monotone after one step.
  template <LocalContactLaw Law>
  Reaction solve_compliant(const Law& law, const Reaction& b, const Reaction& guess) const {
    if (b[0] >= 0) return Reaction::Zero();
    double normal = guess[0] > 0 ? guess[0] : -b[0] / shifted_(0, 0);
    Reaction r = guess;
    for (int k = 0; k < 100; ++k) {
      const double slope = law.compliance_slope(normal);
      Matrix w = shifted_;
      w(0, 0) += slope;
      Reaction shifted_b = b;
      shifted_b[0] += law.compliance(normal) - slope * normal;
      if constexpr (N == 1)
        r[0] = shifted_b[0] >= 0 ? 0.0 : -shifted_b[0] / w(0, 0);
      else
        r = solve_rigid(w, w.inverse(), law.friction, shifted_b, r);
      // A tangent taken far above the root can point below zero: come down by a factor instead.
      const double next = r[0] > 0 ? r[0] : 0.01 * normal;
      const bool done = std::abs(next - normal) <= 1e-15 * normal;
      normal = next;
      if (done) break;
    }
    return r;
  }

  static double smallest_eigenvalue(const Matrix& a) {
    if constexpr (N == 1) return a(0, 0);
    if constexpr (N == 2) {
      const double mean = 0.5 * (a(0, 0) + a(1, 1));
      return mean - std::hypot(0.5 * (a(0, 0) - a(1, 1)), a(0, 1));
    }
    if constexpr (N == 3) {
      // Trigonometric solution of the characteristic cubic of a symmetric matrix.
      const double mean = a.trace() / 3;
      const Matrix deviator = a - mean * Matrix::Identity();
      const double size = std::sqrt(deviator.squaredNorm() / 6);
      if (size <= 1e-14 * std::abs(mean)) return mean;
      const double half_det = std::clamp((deviator / size).determinant() / 2, -1.0, 1.0);
      return mean + 2 * size * std::cos(std::acos(half_det) / 3 + 2.0943951023931953);
    }
  }

  Matrix w_ = Matrix::Zero();
  Matrix shifted_ = Matrix::Zero();  // w_ + proximal_
  Matrix inverse_ = Matrix::Zero();  // of shifted_
  double proximal_ = 0;
  bool solvable_ = false;
};

/// Local solution where the block is diagonal with equal tangential entries, as between balls: the normal
/// first, then the tangential reaction projected on the disk |r_T| <= friction r_N. Exact.
template <int N>
class LocalSolver<N, IsotropicBlock> {
 public:
  LocalSolver() = default;
  explicit LocalSolver(const IsotropicBlock& block)
      : normal_(block.normal),
        inverse_normal_(block.normal > 0 ? 1 / block.normal : 0),
        inverse_tangential_(block.tangential > 0 ? 1 / block.tangential : 0) {}

  template <LocalContactLaw Law>
  ContactVector<N> solve(const Law& law, const ContactVector<N>& velocity, const ContactVector<N>& r) const {
    ContactVector<N> next;
    if constexpr (Law::is_compliant) {
      const double b = velocity[0] - normal_ * r[0];
      next[0] = LocalSolver<1>(Eigen::Matrix<double, 1, 1>(normal_))
                    .solve(law, ContactVector<1>(b + normal_ * r[0]), ContactVector<1>(r[0]))[0];
    } else {
      next[0] = std::max(0.0, r[0] - velocity[0] * inverse_normal_);
    }
    if constexpr (N > 1) {
      auto tangential = next.template tail<N - 1>();
      tangential = r.template tail<N - 1>() - velocity.template tail<N - 1>() * inverse_tangential_;
      const double limit = law.friction * next[0], size2 = tangential.squaredNorm();
      if (size2 > limit * limit) tangential *= limit / std::sqrt(size2);
    }
    return next;
  }

 private:
  double normal_ = 0, inverse_normal_ = 0, inverse_tangential_ = 0;
};

}  // namespace jampack
