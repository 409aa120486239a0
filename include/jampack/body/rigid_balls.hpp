// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <jampack/core/error.hpp>
#include <jampack/geometry/ball.hpp>
#include <string>
#include <utility>

namespace jampack {

/// Rigid balls in motion: Dim velocities and a spin each.
template <int Dim>
requires SupportedDimension<Dim>
struct RigidBalls {
  Balls<Dim> balls;
  Array<double> mass;           ///< m > 0
  Array<double> inertia;        ///< about the centre; isotropic, so a ball has no gyroscopic moment
  Array<Vector<Dim>> velocity;  ///< of the centres
  Array<Spin<Dim>> spin;        ///< rad / time, global axes
  Array<Vector<Dim>> force;     ///< applied at the centres (weight, a push)

  Index size() const { return balls.size(); }

  double kinetic_energy() const {
    double sum = 0.0;
    for (Index i = 0; i < size(); ++i)
      sum += 0.5 * (mass[i] * velocity[i].squaredNorm() + inertia[i] * spin[i].squaredNorm());
    return sum;
  }
  Vector<Dim> momentum() const {
    Vector<Dim> sum = Vector<Dim>::Zero();
    for (Index i = 0; i < size(); ++i) sum += mass[i] * velocity[i];
    return sum;
  }
  /// About the origin.
  Spin<Dim> angular_momentum() const {
    Spin<Dim> sum = Spin<Dim>::Zero();
    for (Index i = 0; i < size(); ++i)
      sum += moment<Dim>(balls.position[i], mass[i] * velocity[i]) + inertia[i] * spin[i];
    return sum;
  }
  double total_mass() const {
    double sum = 0.0;
    for (const double m : mass) sum += m;
    return sum;
  }
};

/// Homogeneous solid balls at rest: m = density * volume, I = m d^2 / 10 (sphere) or m d^2 / 8 (disk).
/// Throws InvalidInput for unusable balls or a density that is not positive.
template <int Dim>
RigidBalls<Dim> rigid_balls(Balls<Dim> balls, double density) {
  require_usable(balls);
  require(std::isfinite(density) && density > 0,
          "rigid balls: the density must be positive and finite, got " + std::to_string(density));
  RigidBalls<Dim> rigid;
  const Index n = balls.size();
  rigid.mass.resize(n);
  rigid.inertia.resize(n);
  for (Index i = 0; i < n; ++i) {
    const double d = balls.diameter[i];
    rigid.mass[i] = density * ball_volume<Dim>(d);
    rigid.inertia[i] = rigid.mass[i] * d * d / (Dim == 3 ? 10.0 : 8.0);
  }
  rigid.velocity.assign(n, Vector<Dim>::Zero());
  rigid.spin.assign(n, Spin<Dim>::Zero());
  rigid.force.assign(n, Vector<Dim>::Zero());
  rigid.balls = std::move(balls);
  return rigid;
}

}  // namespace jampack
