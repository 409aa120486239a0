// SPDX-License-Identifier: MIT
#include <algorithm>
#include <jampack/core/dimension.hpp>
#include <jampack/law/hertz_check.hpp>
#include <jampack/solver/local_solver.hpp>
#include <numbers>
#include <random>

#include "../catch.hpp"

using namespace jampack;

namespace {

// Relative natural map: the certificate of a solution, whatever found it.
template <int N, class Law>
double error_of(const Law& law, const Eigen::Matrix<double, N, N>& w, const ContactVector<N>& b,
                const ContactVector<N>& r) {
  const double rho = N / w.trace();
  return natural_map<N>(law, r, ContactVector<N>(w * r + b), rho).norm() / std::max(r.norm(), rho * b.norm());
}

template <int N>
Eigen::Matrix<double, N, N> random_matrix(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  Eigen::Matrix<double, N, N> a;
  for (Index i = 0; i < a.size(); ++i) a.data()[i] = normal(random);
  return a;
}

// Slow reference in 3D: the slip direction by bisection between 4000 angles.
int slip_solutions(double friction, const Matrix<3>& w, const Vector<3>& b, Array<Vector<3>>& found) {
  const SlipEquation equation(w, b, friction);
  const auto g = [&](double angle) { return equation.misfit(std::cos(angle), std::sin(angle)); };
  constexpr int n = 4000;
  for (int k = 0; k < n; ++k) {
    double low = 2 * std::numbers::pi * k / n, high = 2 * std::numbers::pi * (k + 1) / n;
    if ((g(low) > 0) == (g(high) > 0)) continue;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      ((g(middle) > 0) == (g(low) > 0) ? low : high) = middle;
    }
    const Eigen::Vector2d d(std::cos(low), std::sin(low));
    const double stiffness = equation.normal_stiffness(d[0], d[1]);
    if (stiffness <= 0 || equation.speed(d[0], d[1]) < 0) continue;
    const double normal = -b[0] / stiffness;
    found.push_back(Vector<3>(normal, -friction * normal * d[0], -friction * normal * d[1]));
  }
  return static_cast<int>(found.size());
}

}  // namespace

TEMPLATE_TEST_CASE_SIG("A million random local problems, unsymmetric ones among them, at any scale", "",
                       ((int N), N), 1, 2, 3) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0, 1);
  double worst = 0;
  for (int k = 0; k < 1000000; ++k) {
    const auto a = random_matrix<N>(random);
    // Every second block is as close to singular as can be: rank 1 and up to nine digits less.
    const double least = k % 2 == 0 ? 1e-3 : std::pow(10, -9 * uniform(random));
    Eigen::Matrix<double, N, N> w = least * Eigen::Matrix<double, N, N>::Identity();
    if (k % 2 == 0)
      w += a * a.transpose();
    else
      w += a.col(0) * a.col(0).transpose();
    if (k % 6 == 0) w += 1e-4 * random_matrix<N>(random);
    const double unit_of_w = std::pow(10, 18 * uniform(random) - 9),
                 unit_of_u = std::pow(10, 18 * uniform(random) - 9);
    w *= unit_of_w;
    ContactVector<N> b, guess;
    for (int i = 0; i < N; ++i) {
      b[i] = unit_of_u * normal(random);
      guess[i] = unit_of_u / unit_of_w * normal(random);
    }
    const SignoriniCoulomb law{k % 5 == 0 ? 0.0 : std::pow(10, 3 * uniform(random) - 2)};
    const ContactVector<N> r = LocalSolver<N>(w).solve(law, ContactVector<N>(w * guess + b), guess);
    // The velocity at the guess holds W guess + b: a large guess rounds b away.
    const double rho = N / w.trace(), scale = std::max(r.norm(), rho * b.norm());
    worst = std::max(worst, error_of<N>(law, w, b, r) * scale / std::max(scale, guess.norm()));
  }
  CHECK(worst < 1e-10);
}

TEST_CASE("The local solution in 3D is one of those a slow search finds") {
  std::mt19937_64 random(12);
  std::normal_distribution<double> normal;
  int n_slipping = 0;
  for (int k = 0; k < 2000; ++k) {
    const Matrix<3> a = random_matrix<3>(random), w = a * a.transpose() + 1e-2 * Matrix<3>::Identity();
    const Vector<3> b(-std::abs(normal(random)), normal(random), normal(random));
    const SignoriniCoulomb law{0.3};
    const Vector<3> r = LocalSolver<3>(w).solve(law, b, Vector<3>::Zero().eval()), u = w * r + b;
    if (u.norm() < 1e-9 * b.norm()) continue;  // sticks
    Array<Vector<3>> solutions;
    slip_solutions(law.friction, w, b, solutions);
    REQUIRE(!solutions.empty());
    double nearest = 1e300;
    for (const auto& solution : solutions) nearest = std::min(nearest, (solution - r).norm());
    REQUIRE(nearest <= 1e-9 * r.norm());
    ++n_slipping;
  }
  CHECK(n_slipping > 500);
}

namespace {

// A block of exactly the given rank (small binary fractions, so that no product is rounded), positive
// semi-definite, or slightly unsymmetric with the same null space.
template <int N>
Eigen::Matrix<double, N, N> singular_block(int rank, bool unsymmetric, std::mt19937_64& random) {
  std::uniform_int_distribution<int> digit(-15, 15);
  Eigen::Matrix<double, N, N> w = Eigen::Matrix<double, N, N>::Zero();
  while (w.trace() == 0) {
    w.setZero();
    for (int k = 0; k < rank; ++k) {
      ContactVector<N> a, change = ContactVector<N>::Zero();
      for (int i = 0; i < N; ++i) {
        a[i] = digit(random) / 8.0;
        if (unsymmetric) change[i] = digit(random) / 8192.0;
      }
      w += (a + change) * a.transpose();
    }
  }
  return w;
}

// Reaction and velocity that satisfy the law.
template <int N>
void random_solution(double friction, std::mt19937_64& random, ContactVector<N>& r, ContactVector<N>& u) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0, 1);
  r.setZero();
  u.setZero();
  const double kind = uniform(random);
  Eigen::Matrix<double, N - 1, 1> d;
  for (int i = 0; i < N - 1; ++i) d[i] = normal(random);
  if (kind < 0.1) {
    u[0] = std::abs(normal(random));
    u.template tail<N - 1>() = d;
    return;
  }
  d.normalize();
  r[0] = std::abs(normal(random));
  const bool slips = kind > 0.5;
  r.template tail<N - 1>() = -(slips ? 1 : kind < 0.2 ? 1.0 : uniform(random)) * friction * r[0] * d;
  if (slips) u.template tail<N - 1>() = std::abs(normal(random)) * d;
}

}  // namespace

TEMPLATE_TEST_CASE_SIG("Singular blocks of any rank are solved wherever a solution exists", "", ((int N), N),
                       2, 3) {
  std::mt19937_64 random(21);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0, 1);
  double worst = 0;
  for (int k = 0; k < 500000; ++k) {
    const int rank = 1 + k % (N - 1);
    const double unit_of_w = std::exp2(std::floor(60 * uniform(random) - 30)),
                 unit_of_u = std::exp2(std::floor(60 * uniform(random) - 30));
    const Eigen::Matrix<double, N, N> w = unit_of_w * singular_block<N>(rank, k % 3 == 0, random);
    const SignoriniCoulomb law{k % 5 == 0 ? 0.0 : std::pow(10, 4 * uniform(random) - 3)};
    ContactVector<N> r, u, guess = ContactVector<N>::Zero();
    random_solution<N>(law.friction, random, r, u);
    r *= unit_of_u / unit_of_w;
    u *= unit_of_u;
    const ContactVector<N> b = u - w * r;
    if (k % 2 == 0)
      for (int i = 0; i < N; ++i) guess[i] = unit_of_u / unit_of_w * normal(random);
    const LocalSolver<N> solver(w);
    const ContactVector<N> velocity = w * guess + b, found = solver.solve(law, velocity, guess);
    // What rounding b does to the problem is of the order of |r|, which the solution found need not have.
    const double rho = N / w.trace();
    const double scale = std::max({found.norm(), rho * b.norm(), r.norm(), guess.norm()});
    const double error = natural_map<N>(law, found, ContactVector<N>(w * found + b), rho).norm() / scale;
    worst = std::max(worst, error);
  }
  CHECK(worst < 1e-12);
}

TEST_CASE("A local problem without solution gives a finite reaction and says so") {
  std::mt19937_64 random(22);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 10000; ++k) {
    // No reaction moves the contact along the normal, and it approaches.
    Matrix<3> w = Matrix<3>::Zero();
    const Eigen::Vector2d a(normal(random), normal(random));
    w.bottomRightCorner<2, 2>() = a * a.transpose();
    const Vector<3> velocity(-std::abs(normal(random)), normal(random), normal(random)),
        guess(std::abs(normal(random)), 0, 0);
    const LocalSolver<3> solver(w);
    const SignoriniCoulomb law{0.1 * (k % 10)};
    const Vector<3> r = solver.solve(law, velocity, guess);
    REQUIRE(r.allFinite());
    REQUIRE(r.norm() < 1e3 * (guess.norm() + velocity.norm() / w.trace()));
    REQUIRE(solver.error(law, velocity, guess, r) > 1e-6);
  }
}

TEST_CASE("A zero block leaves the reaction or opens the contact, in finite numbers") {
  const LocalSolver<3> solver(Matrix<3>::Zero().eval());
  const SignoriniCoulomb law{0.5};
  const Vector<3> r(1, 0.1, 0);
  CHECK(solver.solve(law, Vector<3>(1, 0, 0), r) == Vector<3>::Zero());
  CHECK(solver.solve(law, Vector<3>(-1, 0, 0), r) == r);
}

TEST_CASE("The isotropic block gives what the full block gives") {
  std::mt19937_64 random(14);
  std::normal_distribution<double> normal;
  const IsotropicBlock block{2, 7};
  const LocalSolver<3, IsotropicBlock> isotropic(block);
  const LocalSolver<3> full(full_block<3>(block));
  for (int k = 0; k < 10000; ++k) {
    const Vector<3> b(normal(random), normal(random), normal(random));
    const SignoriniCoulomb law{0.4};
    const Vector<3> zero = Vector<3>::Zero();
    REQUIRE((isotropic.solve(law, b, zero) - full.solve(law, b, zero)).norm() <= 1e-13);
    const CompliantContact compliant{3, 2.0 / 3, 0.4};
    const Vector<3> x = isotropic.solve(compliant, b, zero), y = full.solve(compliant, b, zero);
    REQUIRE((x - y).norm() <= 1e-12);
    REQUIRE(error_of<3>(compliant, full_block<3>(block), b, x) < 1e-12);
  }
}
