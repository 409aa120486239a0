// SPDX-License-Identifier: MIT
#include <jampack/geometry/ball.hpp>
#include <jampack/geometry/box.hpp>
#include <jampack/geometry/orientation.hpp>
#include <numbers>

#include "../catch.hpp"

using namespace jampack;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

TEST_CASE("A turn by the rotation vector is Rodrigues' rotation, for large, small and no angles") {
  for (const double angle : {0.0, 1e-9, 1e-5, 9.9e-5, 1.1e-4, 0.3, 2.0, std::numbers::pi, 5.0}) {
    const Vector<3> axis = Vector<3>(1, -2, 0.5).normalized();
    const Matrix<3> expected = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    const Matrix<3> turned_frame = rotation_matrix<3>(turned<3>(no_rotation<3>(), angle * axis));
    CHECK_THAT((turned_frame - expected).norm(), WithinAbs(0.0, 1e-14));
    const Matrix<2> in_plane = rotation_matrix<2>(turned<2>(0.2, Spin<2>(angle)));
    CHECK_THAT((in_plane - Eigen::Rotation2Dd(0.2 + angle).toRotationMatrix()).norm(), WithinAbs(0.0, 1e-14));
  }
}

TEST_CASE("Many turns keep a rotation a rotation, and compose in global axes") {
  Orientation<3> orientation = no_rotation<3>();
  Matrix<3> product = Matrix<3>::Identity();
  for (int k = 0; k < 1000; ++k) {
    const Vector<3> turn(0.1 * std::sin(k), 0.05, 0.1 * std::cos(2 * k));
    orientation = turned<3>(orientation, turn);
    product = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * product;
  }
  CHECK_THAT((rotation_matrix<3>(orientation) - product).norm(), WithinAbs(0.0, 1e-12));
}

TEMPLATE_TEST_CASE_SIG("spin x lever and lever x force are adjoint: the power of a force is moment . spin",
                       "", ((int Dim), Dim), 2, 3) {
  for (int k = 0; k < 100; ++k) {
    const Vector<Dim> lever = Vector<Dim>::Random(), force = Vector<Dim>::Random();
    const Spin<Dim> spin = Spin<Dim>::Random();
    CHECK_THAT(spin_cross<Dim>(spin, lever).dot(force),
               WithinAbs(moment<Dim>(lever, force).dot(spin), 1e-15));
  }
}

TEMPLATE_TEST_CASE_SIG("The walls of a box look inwards and lie on its faces", "", ((int Dim), Dim), 2, 3) {
  Box<Dim> box;
  box.lower = Vector<Dim>::LinSpaced(-1.0, -3.0);
  box.upper = Vector<Dim>::LinSpaced(2.0, 5.0);
  double area = 0.0;
  for (Index w = 0; w < Box<Dim>::n_walls; ++w) {
    const auto wall = box.wall(w);
    CHECK_THAT(wall.distance(box.centre()), WithinRel(0.5 * box.lengths()[w / 2], 1e-15));
    CHECK(wall.distance(w % 2 == 0 ? box.lower : box.upper) == 0.0);
    area += box.wall_area(w) * wall.distance(box.centre());
  }
  CHECK_THAT(area / Dim, WithinRel(box.volume(), 1e-14));  // the pyramids on the walls fill the box
}

TEST_CASE("Unusable balls and boxes are refused by the name of what is wrong") {
  using jampack_tests::contains;
  Balls<3> balls;
  CHECK_THROWS_WITH(require_usable(balls), contains("zero"));
  balls.add(1.0, Vector<3>::Zero());
  balls.add(-1.0, Vector<3>::Ones());
  CHECK_THROWS_WITH(require_usable(balls), contains("ball 1"));
  balls.diameter[1] = 1.0;
  balls.position[1][2] = std::nan("");
  CHECK_THROWS_WITH(require_usable(balls), contains("position of ball 1"));
  CHECK_THROWS_AS(require_usable(Box<2>{{0, 0}, {1, 0}}), InvalidInput);
}
