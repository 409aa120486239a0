// SPDX-License-Identifier: MIT
#include <Eigen/LU>
#include <jampack/solver/gmres.hpp>
#include <random>

#include "../catch.hpp"

using namespace jampack;

namespace {

constexpr Index n = 30;

struct System {
  Eigen::MatrixXd a;
  Eigen::VectorXd b;
  explicit System(double asymmetry) {
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    a = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return asymmetry * normal(random); });
    a.diagonal().array() += 1;
    b = Eigen::VectorXd::NullaryExpr(n, [&] { return normal(random); });
  }
  void operator()(const Eigen::VectorXd& x, Eigen::VectorXd& y) const { y = a * x; }
};

const auto no_preconditioner = [](Eigen::VectorXd&) {};

}  // namespace

TEST_CASE("GMRES solves unsymmetric systems in as many iterations as unknowns, and says what is left") {
  const System system(0.5);  // far from normal, indefinite
  Eigen::VectorXd x = system.b;
  const double left = gmres(system, no_preconditioner, x, 1e-12, n);
  CHECK(left <= 1e-10);
  CHECK((x - system.a.lu().solve(system.b)).norm() <= 1e-8 * x.norm());
}

TEST_CASE("GMRES stopped early has lowered the residual to what it returns") {
  const System system(0.05);
  Eigen::VectorXd x = system.b;
  const double left = gmres(system, no_preconditioner, x, 1e-14, 5);
  CHECK(left > 1e-14);
  CHECK(left < 0.2);
  CHECK((system.b - system.a * x).norm() / system.b.norm() == Approx(left).epsilon(1e-8));
}

TEST_CASE("GMRES preconditioned by the inverse needs one iteration") {
  const System system(0.5);
  const auto lu = system.a.lu();
  Eigen::VectorXd x = system.b;
  const double left = gmres(
      system, [&](Eigen::VectorXd& v) { v = lu.solve(v).eval(); }, x, 1e-9, 1);
  CHECK(left <= 1e-9);
  CHECK((system.a * x - system.b).norm() <= 1e-9 * system.b.norm());
}

TEST_CASE("GMRES on nothing, on zero and on what is not finite") {
  const System system(0.5);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  CHECK(gmres(system, no_preconditioner, x, 1e-9, n) == 0);
  CHECK(x.isZero(0));
  x = system.b;
  const auto zero = [](const Eigen::VectorXd& v, Eigen::VectorXd& out) { out = 0 * v; };
  CHECK(std::isinf(gmres(zero, no_preconditioner, x, 1e-9, n)));
  CHECK((x == system.b));
  const auto nan = [](const Eigen::VectorXd& v, Eigen::VectorXd& out) { out = v * std::nan(""); };
  CHECK(std::isinf(gmres(nan, no_preconditioner, x, 1e-9, n)));
  CHECK((x == system.b));
  x[3] = std::nan("");
  CHECK(std::isinf(gmres(system, no_preconditioner, x, 1e-9, n)));
  CHECK(x[0] == system.b[0]);
}
