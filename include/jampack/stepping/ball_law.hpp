// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <jampack/core/error.hpp>
#include <jampack/detection/ball_gaps.hpp>
#include <jampack/law/hertz_check.hpp>
#include <jampack/law/signorini.hpp>
#include <jampack/law/signorini_coulomb.hpp>
#include <string>

namespace jampack {

/// What a law makes of one contact of balls, when reactions are impulses over a step h and the unilateral
/// condition stands on u_N + gap / (theta h). `wall_friction` takes the place of the law's own at a wall.
template <int Dim>
Signorini ball_law(const Signorini& law, const Balls<Dim>&, const BallGap<Dim>&, double, double, double) {
  return law;
}

template <int Dim>
SignoriniCoulomb ball_law(const SignoriniCoulomb& law, const Balls<Dim>&, const BallGap<Dim>& contact, double,
                          double, double wall_friction) {
  return {contact.at_wall() ? wall_friction : law.friction};
}

namespace detail {

template <int Dim>
CompliantContact hertz_ball_law(const HertzCheck& law, const Balls<Dim>& balls, const BallGap<Dim>& contact,
                                double h, double theta, double friction) {
  const double radius = 0.5 * balls.diameter[contact.candidate];
  double relative_radius = radius;  // a wall is flat
  if (!contact.at_wall()) {
    const double other = 0.5 * balls.diameter[contact.antagonist];
    relative_radius = radius * other / (radius + other);
  }
  const double modulus = contact.at_wall() ? law.modulus_at_wall() : law.modulus_of_two_grains();
  CompliantContact local = law.contact<Dim>(modulus, relative_radius, h, friction);
  local.coefficient /= theta;
  return local;
}

}  // namespace detail

template <int Dim>
CompliantContact ball_law(const HertzCheck& law, const Balls<Dim>& balls, const BallGap<Dim>& contact,
                          double h, double theta, double) {
  return detail::hertz_ball_law(law, balls, contact, h, theta, 0.0);
}

template <int Dim>
CompliantContact ball_law(const HertzCheckCoulomb& law, const Balls<Dim>& balls, const BallGap<Dim>& contact,
                          double h, double theta, double wall_friction) {
  return detail::hertz_ball_law(law, balls, contact, h, theta,
                                contact.at_wall() ? wall_friction : law.friction);
}

/// Coulomb's coefficient of a law between balls, 0 for a law without friction.
template <class Law>
double friction_between_balls(const Law& law) {
  if constexpr (requires { law.friction; })
    return law.friction;
  else
    return 0.0;
}

/// Throws InvalidInput when a law's parameters are outside their ranges.
template <class Law>
void require_usable_law(const Law& law) {
  const double friction = friction_between_balls(law);
  require(std::isfinite(friction) && friction >= 0,
          "contact law: friction must be finite and not negative, got " + std::to_string(friction));
  if constexpr (requires { law.young; }) {
    require(std::isfinite(law.young) && law.young > 0,
            "contact law: Young's modulus must be positive and finite, got " + std::to_string(law.young));
    require(law.poisson > -1 && law.poisson <= 0.5,
            "contact law: Poisson's ratio must be in (-1, 0.5], got " + std::to_string(law.poisson));
    require(
        std::isfinite(law.stiffness_2d) && law.stiffness_2d > 0,
        "contact law: the 2D stiffness must be positive and finite, got " + std::to_string(law.stiffness_2d));
  }
}

}  // namespace jampack
