// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>

namespace jampack {

/// How well a sliding direction is wanted: to round-off, or for a sweep, which comes back: off by the cube of
/// the last change of its angle, where that was at most a tenth.
enum class SlipAccuracy { exact, for_a_sweep };

/// Slip of one contact in 3D (docs/theory/contact_solvers.md, eq. 12 to 14): with the unit direction d of the
/// sliding velocity, friction mu and u = W r + b, b_N < 0,
///   r_N = -b_N / A(d),  A(d) = W_NN - mu W_NT . d > 0,   A u_T = V(d) = p + Q d,
///   p = W_NN b_T - b_N W_TN,   Q = mu (b_N W_TT - b_T W_NT),
/// and d is right where V is parallel to d: g(d) = d_perp . V = 0 and V . d >= 0. g is a trigonometric
/// polynomial of degree 2: a quartic in the tangent of half the angle.
struct SlipEquation {
  double p1, p2, q11, q12, q21, q22;
  double w_nn, w_n1, w_n2;  ///< A(d) = w_nn - w_n1 d1 - w_n2 d2 (friction multiplied in)

  [[gnu::always_inline]] SlipEquation(const Eigen::Matrix3d& w, const Eigen::Vector3d& b, double friction)
      : p1(w(0, 0) * b[1] - b[0] * w(1, 0)),
        p2(w(0, 0) * b[2] - b[0] * w(2, 0)),
        q11(friction * (b[0] * w(1, 1) - b[1] * w(0, 1))),
        q12(friction * (b[0] * w(1, 2) - b[1] * w(0, 2))),
        q21(friction * (b[0] * w(2, 1) - b[2] * w(0, 1))),
        q22(friction * (b[0] * w(2, 2) - b[2] * w(0, 2))),
        w_nn(w(0, 0)),
        w_n1(friction * w(0, 1)),
        w_n2(friction * w(0, 2)) {}

  [[gnu::always_inline]] double normal_stiffness(double d1, double d2) const {
    return w_nn - w_n1 * d1 - w_n2 * d2;
  }
  [[gnu::always_inline]] double speed(double d1, double d2) const {  // V . d
    return d1 * (p1 + q11 * d1 + q12 * d2) + d2 * (p2 + q21 * d1 + q22 * d2);
  }
  [[gnu::always_inline]] double misfit(double d1, double d2) const {  // g
    return d1 * (p2 + q21 * d1 + q22 * d2) - d2 * (p1 + q11 * d1 + q12 * d2);
  }
  [[gnu::always_inline]] double misfit_slope(double d1, double d2) const {  // dg / d angle
    return -p1 * d1 - p2 * d2 + (d1 * d1 - d2 * d2) * (q22 - q11) - 2 * d1 * d2 * (q12 + q21);
  }
  [[gnu::always_inline]] double misfit_curvature(double d1, double d2) const {  // d2g / d angle2
    return p1 * d2 - p2 * d1 - 4 * d1 * d2 * (q22 - q11) - 2 * (d1 * d1 - d2 * d2) * (q12 + q21);
  }
  double scale() const {
    return std::abs(p1) + std::abs(p2) + std::abs(q11) + std::abs(q12) + std::abs(q21) + std::abs(q22);
  }

  /// Halley's method on the angle from the unit vector d, which it changes; true if it ends at a solution.
  template <SlipAccuracy accuracy>
  [[gnu::always_inline]] bool follow(double& d1, double& d2) const {
    const double enough = 4e-16 * scale();
    for (int iteration = 0; iteration < 12; ++iteration) {
      const double g = misfit(d1, d2), slope = misfit_slope(d1, d2);
      if (std::abs(g) <= enough) return speed(d1, d2) >= 0 && normal_stiffness(d1, d2) > 0;
      if (!(slope < 0)) return false;  // where g grows with the angle the solution is not the one sought
      const double inverse = 1 / slope, newton = -g * inverse;
      if (!(std::abs(newton) < 2)) return false;
      const double bend = 0.5 * misfit_curvature(d1, d2) * inverse * newton;
      const double angle = std::abs(bend) < 0.5 ? newton - bend * newton : newton;
      turn(angle, d1, d2);
      // Cubic convergence: the angle is off by about its third power now.
      constexpr double small = accuracy == SlipAccuracy::exact ? 1e-5 : 0.1;
      if (std::abs(angle) < small) return speed(d1, d2) >= 0 && normal_stiffness(d1, d2) > 0;
    }
    return false;
  }

  /// All directions that can be solutions: the real roots of g, found by bracketing between the roots of the
  /// derivatives of the quartic, and those extrema of g that come near zero without crossing it. Returns
  /// their number (at most 14; each root is there, others may be too).
  int candidates(std::array<Eigen::Vector2d, 14>& found) const {
    int n = 0;
    // Half circle by half circle, d = +-((1 - t^2), 2 t)/(1 + t^2) with |t| <= 1:
    // (1 + t^2)^2 g = sum of coefficient_k t^k.
    for (const double sign : {1.0, -1.0}) {
      const double a = sign * p2, b = sign * p1, c = q22 - q11;
      const std::array<double, 5> quartic = {a + q21, -2 * b + 2 * c, -2 * q21 - 4 * q12, -2 * b - 2 * c,
                                             -a + q21};
      std::array<double, 8> roots;
      const int count = roots_within_one(quartic, roots);
      for (int i = 0; i < count && n < 14; ++i) {
        const double t = roots[static_cast<std::size_t>(i)], f = sign / (1 + t * t);
        found[static_cast<std::size_t>(n++)] = Eigen::Vector2d(f * (1 - t * t), f * 2 * t);
      }
    }
    return n;
  }

 private:
  // Turns a unit vector by an angle, to third order in it; where that is little without a root to wait for.
  [[gnu::always_inline]] static void turn(double angle, double& d1, double& d2) {
    const double square = angle * angle, tangent = angle + angle * square / 3, s = tangent * tangent;
    const double cosine = s < 1e-4 ? 1 + s * (-0.5 + s * (0.375 + s * (-0.3125))) : 1 / std::sqrt(1 + s);
    const double e1 = (d1 - tangent * d2) * cosine;
    d2 = (d2 + tangent * d1) * cosine;
    d1 = e1;
  }
  static double value(const std::array<double, 5>& c, int degree, double t) {
    double v = c[static_cast<std::size_t>(degree)];
    for (int k = degree - 1; k >= 0; --k) v = v * t + c[static_cast<std::size_t>(k)];
    return v;
  }

  // Root in [low, high], over which the polynomial changes sign and is monotone.
  static double bracketed_root(const std::array<double, 5>& c, int degree, double low, double high) {
    double f_low = value(c, degree, low);
    const double f_high = value(c, degree, high);
    if (f_low == 0) return low;
    if (f_high == 0) return high;
    double t = 0.5 * (low + high);
    for (int iteration = 0; iteration < 200; ++iteration) {
      const double f = value(c, degree, t);
      if (f == 0) return t;
      if ((f > 0) == (f_low > 0)) {
        low = t;
        f_low = f;
      } else {
        high = t;
      }
      double slope = 0;
      for (int k = degree; k >= 1; --k) slope = slope * t + k * c[static_cast<std::size_t>(k)];
      const double newton = t - f / slope;
      // Newton where it stays inside and bisection every third time, so that the bracket always shrinks.
      const double next = (iteration % 3 != 2 && newton > low && newton < high) ? newton : 0.5 * (low + high);
      if (next == t || high - low < 1e-16) return next;
      t = next;
    }
    return t;
  }

  // Roots in [-1, 1] of the polynomial of degree 4 and, beside them, its extrema there.
  static int roots_within_one(const std::array<double, 5>& quartic, std::array<double, 8>& out) {
    std::array<double, 4> points{};  // roots of the derivative of the order at hand
    int n_points = 0;
    for (int degree = 1; degree <= 4; ++degree) {
      // (4 - degree)-th derivative of the quartic.
      std::array<double, 5> c{};
      for (int k = 0; k <= degree; ++k) {
        double factor = 1;
        for (int m = 0; m < 4 - degree; ++m) factor *= k + 4 - degree - m;
        c[static_cast<std::size_t>(k)] = factor * quartic[static_cast<std::size_t>(k + 4 - degree)];
      }
      std::array<double, 4> next{};
      int n_next = 0;
      double low = -1;
      for (int i = 0; i <= n_points; ++i) {
        const double high = i < n_points ? points[static_cast<std::size_t>(i)] : 1.0;
        const double f_low = value(c, degree, low), f_high = value(c, degree, high);
        if ((f_low <= 0 && f_high > 0) || (f_low >= 0 && f_high < 0) || (f_low != 0 && f_high == 0))
          if (n_next < 4) next[static_cast<std::size_t>(n_next++)] = bracketed_root(c, degree, low, high);
        low = high;
      }
      if (degree == 4) {
        int n = 0;
        for (int i = 0; i < n_next; ++i)
          out[static_cast<std::size_t>(n++)] = next[static_cast<std::size_t>(i)];
        for (int i = 0; i < n_points; ++i)
          out[static_cast<std::size_t>(n++)] = points[static_cast<std::size_t>(i)];
        return n;
      }
      points = next;
      n_points = n_next;
    }
    return 0;
  }
};

}  // namespace jampack
