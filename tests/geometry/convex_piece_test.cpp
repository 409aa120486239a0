// SPDX-License-Identifier: MIT
#include <jampack/geometry/convex_piece.hpp>
#include <random>

#include "../catch.hpp"

using namespace jampack;

namespace {

template <int Dim>
double measure(const ConvexPiece<Dim>& piece) {
  double sum = 0;
  integrate(piece, [&](const auto&, double part) { sum += part; });
  return sum;
}

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a[0] * b[1] - a[1] * b[0];
}

}  // namespace

TEST_CASE("a quadrilateral cut by the sides of a triangle is their intersection") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int n_partial = 0;
  for (int trial = 0; trial < 500; ++trial) {
    // A dual cell's piece of a random triangle, and another triangle.
    std::array<Eigen::Vector2d, 3> base, triangle;
    for (auto* points : {&base, &triangle}) {
      for (auto& point : *points) point = {uniform(random), uniform(random)};
      if (cross((*points)[1] - (*points)[0], (*points)[2] - (*points)[0]) < 0)
        std::swap((*points)[1], (*points)[2]);
    }
    const std::array<Eigen::Vector2d, 4> corners{base[0], (base[0] + base[1]) / 2,
                                                 (base[0] + base[1] + base[2]) / 3, (base[0] + base[2]) / 2};
    ConvexPiece<3> piece;
    for (const auto& corner : corners) piece.push_back(corner);
    const double whole = measure(piece);
    CHECK(whole == Approx(cross(base[1] - base[0], base[2] - base[0]) / 6));
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector2d a = triangle[i], side = triangle[(i + 1) % 3] - a;
      cut(piece, [&](const Eigen::Vector2d& x) { return cross(side, x - a); });
    }
    // By counting points of a fine grid over the piece, its corners taken bilinearly.
    constexpr int n = 100;
    double area = 0;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        const double u = (i + 0.5) / n, v = (j + 0.5) / n;
        const Eigen::Vector2d along = (1 - v) * (corners[1] - corners[0]) + v * (corners[2] - corners[3]);
        const Eigen::Vector2d across = (1 - u) * (corners[3] - corners[0]) + u * (corners[2] - corners[1]);
        const Eigen::Vector2d x =
            (1 - v) * ((1 - u) * corners[0] + u * corners[1]) + v * ((1 - u) * corners[3] + u * corners[2]);
        bool is_inside = true;
        for (std::size_t k = 0; k < 3; ++k)
          is_inside = is_inside && cross(triangle[(k + 1) % 3] - triangle[k], x - triangle[k]) >= 0;
        if (is_inside) area += cross(along, across) / (n * n);
      }
    CHECK(std::abs(measure(piece) - area) < 0.01 * whole);
    n_partial += area > 1e-3 * whole && area < 0.999 * whole;
  }
  CHECK(n_partial > 100);
}

TEST_CASE("quadratures are exact to the degrees they claim") {
  ConvexPiece<3> piece;
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(0, 0), {2, 0}, {2, 1}, {0, 1}})
    piece.push_back(corner);
  double xx = 0, xy = 0;
  integrate(piece, [&](const Eigen::Vector2d& x, double weight) {
    xx += weight * x[0] * x[0];
    xy += weight * x[0] * x[1];
  });
  CHECK(xx == Approx(8.0 / 3));
  CHECK(xy == Approx(1.0));

  ConvexPiece<2> interval;  // the ends in either order
  interval.push_back(ConvexPiece<2>::Point(3.0));
  interval.push_back(ConvexPiece<2>::Point(-1.0));
  cut(interval, [](const auto& x) { return x[0]; });
  REQUIRE(interval.n == 2);
  double cubes = 0;
  integrate(interval, [&](const auto& x, double weight) { cubes += weight * x[0] * x[0] * x[0]; });
  CHECK(cubes == Approx(81.0 / 4));
  cut(interval, [](const auto& x) { return x[0] - 4; });
  CHECK(measure(interval) == 0);
}
