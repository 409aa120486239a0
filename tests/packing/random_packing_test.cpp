// SPDX-License-Identifier: MIT
#include <jampack/packing/random_packing.hpp>

#include "../catch.hpp"

using namespace jampack;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

TEMPLATE_TEST_CASE_SIG("Nothing overlaps in a random packing, whatever the number of grains", "",
                       ((int Dim), Dim), 2, 3) {
  for (const Index n : {1, 2, 3, 5, 10, 50, 300}) {
    const auto packing = random_packing<Dim>({.n_grains = n, .mean_diameter = 0.01, .seed = 11});
    REQUIRE(packing.balls.size() == n);
    for (Index i = 0; i < n; ++i) {
      for (Index j = 0; j < i; ++j)
        CHECK((packing.balls.position[i] - packing.balls.position[j]).norm() >
              0.5 * (packing.balls.diameter[i] + packing.balls.diameter[j]));
      for (Index w = 0; w < Box<Dim>::n_walls; ++w)
        CHECK(packing.box.wall(w).distance(packing.balls.position[i]) >= 0.5 * packing.balls.diameter[i]);
    }
    CHECK_THAT(packing.box.lengths().maxCoeff(), WithinRel(packing.box.lengths().minCoeff(), 1e-15));
  }
}

TEST_CASE("Diameters are uniform in the range asked for") {
  const auto packing = random_packing<2>({.n_grains = 20000, .packing_fraction = 0.001, .seed = 2});
  double mean = 0.0, square = 0.0;
  for (const double d : packing.balls.diameter) {
    CHECK(d >= 0.8);
    CHECK(d < 1.2);
    mean += d / 20000;
    square += d * d / 20000;
  }
  // Mean 1 and variance 0.4^2/12, within four standard errors.
  CHECK_THAT(mean, WithinAbs(1.0, 4 * 0.4 / std::sqrt(12.0 * 20000)));
  CHECK_THAT(square - mean * mean, WithinRel(0.16 / 12, 0.03));
  CHECK_THAT(packing.packing_fraction(), WithinRel(0.001, 1e-9));
}

TEST_CASE("The random source is that of the standard's engine, and uniform") {
  // The 10000th draw of a default-seeded mt19937_64 is fixed by the standard: 9981545732273789042.
  RandomSource random(5489);
  double last = 0.0;
  for (int k = 0; k < 10000; ++k) last = random.unit();
  CHECK(last == static_cast<double>(9981545732273789042ULL >> 11) * 0x1.0p-53);
  // Rotations uniform: the mean of the rotation matrices is zero, within four standard errors of 1/sqrt(3n).
  Matrix<3> mean = Matrix<3>::Zero();
  const int n = 10000;
  for (int k = 0; k < n; ++k) mean += rotation_matrix<3>(random.orientation<3>()) / n;
  CHECK(mean.cwiseAbs().maxCoeff() < 4 / std::sqrt(3.0 * n));
}

TEST_CASE("The same seed gives the same packing, another seed another") {
  const auto a = random_packing<3>({.n_grains = 30, .seed = 8});
  const auto b = random_packing<3>({.n_grains = 30, .seed = 8});
  const auto c = random_packing<3>({.n_grains = 30, .seed = 9});
  CHECK(a.balls.position == b.balls.position);
  CHECK(a.balls.diameter == b.balls.diameter);
  CHECK_FALSE(a.balls.diameter == c.balls.diameter);
}

TEST_CASE("Impossible packings are refused with a line that names the value") {
  using jampack_tests::contains;
  CHECK_THROWS_WITH(random_packing<3>({.n_grains = 0}), contains("number of grains"));
  CHECK_THROWS_WITH(random_packing<3>({.mean_diameter = -1.0}), contains("mean diameter"));
  CHECK_THROWS_WITH(random_packing<3>({.mean_diameter = std::nan("")}), contains("mean diameter"));
  CHECK_THROWS_WITH(random_packing<2>({.polydispersity = 1.0}), contains("polydispersity"));
  CHECK_THROWS_WITH(random_packing<2>({.packing_fraction = 1.5}), contains("packing fraction"));
}
