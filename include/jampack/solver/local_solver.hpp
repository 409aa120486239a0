// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <jampack/law/signorini_coulomb.hpp>
#include <jampack/problem/residual.hpp>
#include <jampack/solver/singular_block.hpp>
#include <jampack/solver/slip_direction.hpp>

namespace jampack {

/// Exact solution of one contact, u = W r + b with the law between r and u, everything else held fixed. It
/// cannot stick: the states open, sticking and slipping are enumerated, slip by all roots of its equation,
/// sticking on a block that is singular (or nearly so) by the points of the cone on W r = -b
/// (docs/theory/contact_solvers.md, section 4). Made once a contact for its block W = W_cc.
///
/// Where no reaction satisfies the law (W_NN = 0, say) the result is a proximal step around the present
/// reaction: finite, a fixed point only of what solves the unchanged problem, and told by `local_error`.
template <int N, class Block = Eigen::Matrix<double, N, N>>
class LocalSolver {
  using Matrix = Eigen::Matrix<double, N, N>;
  using Reaction = ContactVector<N>;

 public:
  LocalSolver() = default;
  explicit LocalSolver(const Block& block) : w_(block) { set_inverse(); }

  /// The reaction that satisfies the law; `velocity` is u at the present reaction `r`. Where the block is
  /// zero the reaction can change nothing and stays.
  template <SlipAccuracy accuracy = SlipAccuracy::exact, LocalContactLaw Law>
  [[gnu::always_inline]] Reaction solve(const Law& law, const Reaction& velocity, const Reaction& r) const {
    if constexpr (!Law::is_compliant && N == 1)
      if (solvable_) return Reaction(std::max(0.0, r[0] - inverse_(0, 0) * velocity[0]));
    Reaction b = product(w_, r);
#pragma GCC unroll 9
    for (int i = 0; i < N; ++i) b[i] = velocity[i] - b[i];
    if constexpr (!Law::is_compliant) {
      if (!solvable_) return velocity[0] > 0 ? Reaction(Reaction::Zero()) : r;
      Reaction stick = product(inverse_, velocity);  // known a product sooner than from b
#pragma GCC unroll 9
      for (int i = 0; i < N; ++i) stick[i] = r[i] - stick[i];
      return solve_rigid<accuracy>(law.friction, b, r, stick);
    } else {
      return solve_compliant(law, b, r);
    }
  }

  /// How far `next`, made by solve(law, velocity, r), is from the law: the natural map over max(|next|,
  /// |rho b|). Round-off wherever a solution exists; of order one where none does.
  template <LocalContactLaw Law>
  double error(const Law& law, const Reaction& velocity, const Reaction& r, const Reaction& next) const {
    const double trace = w_.trace(), rho = trace > 0 ? N / trace : 1.0;
    const Reaction b = velocity - w_ * r;
    const double scale = std::max(next.norm(), rho * b.norm());
    const double map = natural_map<N>(law, next, Reaction(w_ * next + b), rho).norm();
    return scale > 0 ? map / scale : map;
  }

 private:
  // The inverse, and whether it may be used: not where it would cost more than some five digits.
  void set_inverse() {
    const double trace = w_.trace();
    solvable_ = trace > 0;
    if (!solvable_) return;
    inverse_ = (w_ / trace).inverse() / trace;
    // Of rank 1, an inverse by cofactors is noise over noise and may look harmless.
    const double condition = w_.cwiseAbs().maxCoeff() * inverse_.cwiseAbs().maxCoeff();
    const double misfit = (w_ * inverse_ - Matrix::Identity()).cwiseAbs().maxCoeff();
    regular_ = N == 1 || (condition < 1e5 && misfit < 1e-9 && w_(0, 0) > 0);
  }

  // In the usual states, inlined and scalar by scalar: what is stored as scalars and read back as a vector
  // waits for memory, and an update is a chain of operations that wait for each other. Unusual states get
  // copies (a vector whose address is given away lies in memory).
  // `stick` is the sticking reaction, -W^-1 b, where the block is regular.
  template <SlipAccuracy accuracy>
  [[gnu::always_inline]] Reaction solve_rigid(double friction, const Reaction& b, const Reaction& guess,
                                              const Reaction& stick) const {
    if (b[0] >= 0) return Reaction::Zero();
    if constexpr (N == 1) {
      return Reaction(-b[0] / w_(0, 0));
    } else {
      if (!regular_) return solve_singular(friction, b, guess);
      if (stick[0] >= 0 && tangential_square(stick) <= friction * friction * stick[0] * stick[0])
        return stick;
      Reaction r;
      if (slip_near<accuracy>(friction, b, guess, stick, r)) return r;
      return solve_by_candidates(friction, b, guess, stick);
    }
  }

  Reaction solve_rigid(double friction, const Reaction& b, const Reaction& guess) const {
    return solve_rigid<SlipAccuracy::exact>(friction, b, guess, Reaction(-product(inverse_, b)));
  }

  [[gnu::noinline]] Reaction solve_by_candidates(double friction, Reaction b, Reaction guess,
                                                 Reaction stick) const {
    Candidates candidates(w_, friction, b, guess);
    candidates.judge(project_on_friction_cone<N>(stick, friction));
    judge_slip(friction, b, candidates);
    return candidates.best;
  }

  [[gnu::always_inline]] static double row_times(const Matrix& a, int i, const Reaction& x) {
    double sum = a(i, 0) * x[0];
    if constexpr (N > 1) sum += a(i, 1) * x[1];
    if constexpr (N > 2) sum += a(i, 2) * x[2];
    return sum;
  }
  [[gnu::always_inline]] static Reaction product(const Matrix& a, const Reaction& x) {
    Reaction y;
    y[0] = row_times(a, 0, x);
    if constexpr (N > 1) y[1] = row_times(a, 1, x);
    if constexpr (N > 2) y[2] = row_times(a, 2, x);
    return y;
  }
  static double tangential_square(const Reaction& r) {
    double sum = 0;
#pragma GCC unroll 9
    for (int i = 0; i < N - 1; ++i) sum += r[i + 1] * r[i + 1];
    return sum;
  }

  // b_N < 0 and a block whose inverse cannot be trusted.
  [[gnu::noinline]] Reaction solve_singular(double friction, Reaction b, Reaction guess) const {
    constexpr double round_off = 1e-14;
    Candidates candidates(w_, friction, b, guess);
    StickingSet<N>(w_).for_each_rank(friction, b, guess, [&](const Reaction& stick) {
      candidates.judge(project_on_friction_cone<N>(stick, friction));
      return candidates.relative_error() <= round_off;
    });
    if (candidates.relative_error() > round_off) judge_slip(friction, b, candidates);
    if (candidates.relative_error() <= 1e-8) return candidates.best;
    // Nothing satisfies the law: one proximal step, whose block is positive.
    const double shift = w_.cwiseAbs().sum();
    LocalSolver shifted;
    shifted.w_ = w_ + shift * Matrix::Identity();
    shifted.set_inverse();
    return shifted.regular_ ? shifted.solve_rigid(friction, Reaction(b - shift * guess), guess) : guess;
  }

  // States that can be a solution, judged by the natural map.
  struct Candidates {
    const Matrix& w;
    const SignoriniCoulomb law;
    const Reaction &b, &guess;
    const double rho;
    Reaction best = Reaction::Zero();
    double best_error;

    Candidates(const Matrix& block, double friction, const Reaction& load, const Reaction& first)
        : w(block),
          law{friction},
          b(load),
          guess(first),
          rho(N / block.trace()),
          best_error(natural_map<N>(law, best, b, rho).norm()) {}
    void judge(const Reaction& r) {
      const double error = natural_map<N>(law, r, Reaction(w * r + b), rho).norm();
      if (error < best_error) {
        best_error = error;
        best = r;
      }
    }
    // Reactions a million times what loads and guess explain are judged by these: infinity is no solution.
    double relative_error() const {
      const double loads = rho * b.norm(), most = 1e6 * std::max(loads, guess.norm());
      return best_error / std::max(loads, std::min(best.norm(), most));
    }
  };

  // Slip in the direction found at once in 2D, by Halley's method from the last direction in 3D. False where
  // that does not end.
  template <SlipAccuracy accuracy>
  [[gnu::always_inline]] bool slip_near(double friction, const Reaction& b, const Reaction& guess,
                                        const Reaction& stick, Reaction& r) const {
    if constexpr (N == 2) {
      const double against_stick = stick[1] > 0 ? -1.0 : 1.0;
      return slips_along(against_stick, friction, b, r) || slips_along(-against_stick, friction, b, r);
    } else {
      if (friction == 0) {
        r = Reaction(-b[0] / w_(0, 0), 0, 0);
        return true;
      }
      double d1 = -guess[1], d2 = -guess[2], size2 = d1 * d1 + d2 * d2;
      if (!(size2 > 0)) {
        d1 = -stick[1], d2 = -stick[2];
        size2 = d1 * d1 + d2 * d2;
        if (!(size2 > 0)) return false;
      }
      const double inverse_size = 1 / std::sqrt(size2);
      d1 *= inverse_size;
      d2 *= inverse_size;
      const SlipEquation equation(w_, b, friction);
      if (!equation.follow<accuracy>(d1, d2)) return false;
      r = slipping(equation, friction, b[0], d1, d2);
      return true;
    }
  }

  // In 2D, with sliding velocity along d = +-1. False where that contradicts the velocity.
  [[gnu::always_inline]] bool slips_along(double d, double friction, const Reaction& b, Reaction& r) const {
    const double stiffness = w_(0, 0) - friction * d * w_(0, 1);
    const double normal = -b[0] / stiffness, tangential = -friction * d * normal;
    r[0] = normal;
    r[1] = tangential;
    return stiffness > 0 && d * (w_(1, 0) * normal + w_(1, 1) * tangential + b[1]) >= 0;
  }

  static Reaction slipping(const SlipEquation& equation, double friction, double b_n, double d1, double d2) {
    const double normal = -b_n / equation.normal_stiffness(d1, d2);
    return Reaction(normal, -friction * normal * d1, -friction * normal * d2);
  }

  // Every direction in which the contact could slip.
  void judge_slip(double friction, const Reaction& b, Candidates& candidates) const {
    if constexpr (N == 2) {
      for (const double d : {1.0, -1.0}) {
        const double stiffness = w_(0, 0) - friction * d * w_(0, 1);
        if (stiffness > 0) candidates.judge(Reaction(-b[0] / stiffness, friction * d * b[0] / stiffness));
      }
    } else {
      if (w_(0, 0) > 0) candidates.judge(Reaction(-b[0] / w_(0, 0), 0, 0));  // all of it where friction = 0
      const SlipEquation equation(w_, b, friction);
      std::array<Eigen::Vector2d, 14> directions;
      const int n = equation.candidates(directions);
      for (int i = 0; i < n; ++i) {
        const Eigen::Vector2d& d = directions[static_cast<std::size_t>(i)];
        if (equation.normal_stiffness(d[0], d[1]) > 0)
          candidates.judge(slipping(equation, friction, b[0], d[0], d[1]));
      }
    }
  }

  // Newton's method on the compliance, tangent by tangent; each one is a rigid problem with a softer W_NN. It
  // starts from the reaction that is too large (no other compliance acts), from where the iteration of the
  // frictionless problem is monotone after one step.
  template <LocalContactLaw Law>
  Reaction solve_compliant(const Law& law, const Reaction& b, const Reaction& guess) const {
    if (b[0] >= 0) return Reaction::Zero();
    double normal = guess[0] > 0 ? guess[0] : w_(0, 0) > 0 ? -b[0] / w_(0, 0) : 1.0;
    Reaction r = guess;
    LocalSolver tangent;
    for (int k = 0; k < 100; ++k) {
      const double slope = law.compliance_slope(normal);
      tangent.w_ = w_;
      tangent.w_(0, 0) += slope;
      tangent.set_inverse();
      if (!tangent.solvable_) return guess;
      Reaction shifted_b = b;
      shifted_b[0] += law.compliance(normal) - slope * normal;
      r = tangent.solve_rigid(law.friction, shifted_b, r);
      // A tangent taken far above the root can point below zero: come down by a factor instead.
      const double next = r[0] > 0 ? r[0] : 0.01 * normal;
      const bool done = std::abs(next - normal) <= 1e-15 * normal;
      normal = next;
      if (done) break;
    }
    return r;
  }

  Matrix w_ = Matrix::Zero();
  Matrix inverse_ = Matrix::Zero();
  bool solvable_ = false;  // the trace is positive
  bool regular_ = false;   // inverse_ may be used
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

  template <SlipAccuracy = SlipAccuracy::exact, LocalContactLaw Law>
  [[gnu::always_inline]] ContactVector<N> solve(const Law& law, const ContactVector<N>& velocity,
                                                const ContactVector<N>& r) const {
    ContactVector<N> next;
    if constexpr (Law::is_compliant) {
      const double b = velocity[0] - normal_ * r[0];
      next[0] = LocalSolver<1>(Eigen::Matrix<double, 1, 1>(normal_))
                    .solve(law, ContactVector<1>(b + normal_ * r[0]), ContactVector<1>(r[0]))[0];
    } else {
      next[0] = std::max(0.0, r[0] - velocity[0] * inverse_normal_);
    }
    if constexpr (N > 1) {
      double size2 = 0;
#pragma GCC unroll 9
      for (int i = 0; i < N - 1; ++i) {
        next[i + 1] = r[i + 1] - velocity[i + 1] * inverse_tangential_;
        size2 += next[i + 1] * next[i + 1];
      }
      const double limit = law.friction * next[0];
      if (size2 > limit * limit) {
        const double scale = limit / std::sqrt(size2);
#pragma GCC unroll 9
        for (int i = 0; i < N - 1; ++i) next[i + 1] *= scale;
      }
    }
    return next;
  }

 private:
  double normal_ = 0, inverse_normal_ = 0, inverse_tangential_ = 0;
};

}  // namespace jampack
