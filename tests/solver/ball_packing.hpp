// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <jampack/core/dimension.hpp>
#include <jampack/geometry/frame.hpp>
#include <jampack/law/signorini.hpp>
#include <jampack/law/signorini_coulomb.hpp>
#include <jampack/problem/contact_problem.hpp>
#include <jampack/problem/rigid_balls_delassus.hpp>
#include <random>
#include <utility>

namespace jampack_tests {

using jampack::Array;
using jampack::Index;

/// Balls of diameters uniform in [0.8, 1.2], pressed together in a cube by soft repulsion until they are all
/// but at rest: the geometry of a packing just above jamming, in a second or so for 10^5 balls. Numbered cell
/// by cell, as close in memory as they are in space.
template <int Dim>
struct SoftPressedBalls {
  Array<double> diameter;
  Array<jampack::Vector<Dim>> position;
  double edge = 0;  ///< of the cube [0, edge]^Dim
  struct Pair {
    Index candidate, antagonist;  ///< antagonist -1 - wall at walls
    jampack::Vector<Dim> normal;  ///< from antagonist to candidate
  };
  Array<Pair> contacts;  ///< what overlaps, pair by pair

  SoftPressedBalls(Index n, double packing_fraction, std::uint64_t seed, int n_steps = 400)
      : diameter(n), position(n) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    double volume = 0;
    for (double& d : diameter) {
      d = 0.8 + 0.4 * uniform(random);
      volume += jampack::ball_volume<Dim>(d);
    }
    edge = std::pow(volume / packing_fraction, 1.0 / Dim);
    for (auto& x : position)
      for (int i = 0; i < Dim; ++i) x[i] = edge * uniform(random);
    sort_by_cell();
    // FIRE (Bitzek et al., Phys. Rev. Lett. 97, 170201, 2006), stiffness and masses 1.
    Array<jampack::Vector<Dim>> force(n), velocity(n, jampack::Vector<Dim>::Zero());
    double dt = 0.1, mix = 0.1;
    int downhill = 0;
    for (int step = 0; step < n_steps; ++step) {
      find_contacts();
      for (auto& f : force) f.setZero();
      for (const Pair& pair : contacts) {
        const double overlap = -gap(pair);
        force[pair.candidate] += overlap * pair.normal;
        if (pair.antagonist >= 0) force[pair.antagonist] -= overlap * pair.normal;
      }
      double power = 0, speed2 = 0, force2 = 0;
      for (Index b = 0; b < n; ++b) {
        power += force[b].dot(velocity[b]);
        speed2 += velocity[b].squaredNorm();
        force2 += force[b].squaredNorm();
      }
      if (power > 0) {
        const double turn = force2 > 0 ? mix * std::sqrt(speed2 / force2) : 0;
        for (Index b = 0; b < n; ++b) velocity[b] = (1 - mix) * velocity[b] + turn * force[b];
        if (++downhill > 5) {
          dt = std::min(1.1 * dt, 0.5);
          mix *= 0.99;
        }
      } else {
        for (auto& v : velocity) v.setZero();
        dt *= 0.5;
        mix = 0.1;
        downhill = 0;
      }
      for (Index b = 0; b < n; ++b) {
        velocity[b] += dt * force[b];
        position[b] += dt * velocity[b];
      }
    }
    sort_by_cell();
    find_contacts();
  }

  double gap(const Pair& pair) const {
    const auto& x = position[pair.candidate];
    if (pair.antagonist < 0) {
      const double along = pair.normal.dot(x);
      return (pair.normal.maxCoeff() > 0.5 ? along : edge + along) - 0.5 * diameter[pair.candidate];
    }
    return (x - position[pair.antagonist]).norm() -
           0.5 * (diameter[pair.candidate] + diameter[pair.antagonist]);
  }

 private:
  using Cell = std::array<Index, Dim>;
  Index n_cells() const { return std::max<Index>(1, static_cast<Index>(edge / 1.2)); }
  Index cell_of(const jampack::Vector<Dim>& x) const {
    const Index n = n_cells();
    Index cell = 0;
    for (int i = 0; i < Dim; ++i)
      cell = cell * n + std::clamp<Index>(static_cast<Index>(x[i] / edge * static_cast<double>(n)), 0, n - 1);
    return cell;
  }

  void sort_by_cell() {
    Array<std::pair<Index, Index>> order;
    for (Index b = 0; b < position.size(); ++b) order.push_back({cell_of(position[b]), b});
    std::sort(order.begin(), order.end());
    Array<double> d;
    Array<jampack::Vector<Dim>> x;
    for (const auto& [cell, b] : order) {
      d.push_back(diameter[b]);
      x.push_back(position[b]);
    }
    diameter = std::move(d);
    position = std::move(x);
  }

  void find_contacts() {
    contacts.clear();
    const Index n = n_cells();
    Index total = 1;
    for (int i = 0; i < Dim; ++i) total *= n;
    first_.assign(total, Index{-1});
    next_.resize(position.size());
    for (Index b = position.size() - 1; b >= 0; --b) {
      const Index cell = cell_of(position[b]);
      next_[b] = first_[cell];
      first_[cell] = b;
    }
    Index n_neighbours = 1;
    for (int i = 0; i < Dim; ++i) n_neighbours *= 3;
    for (Index a = 0; a < position.size(); ++a) {
      Index cell = cell_of(position[a]);
      Cell at;
      for (int i = Dim - 1; i >= 0; --i) {
        at[static_cast<std::size_t>(i)] = cell % n;
        cell /= n;
      }
      for (Index k = 0; k < n_neighbours; ++k) {
        Index other = 0, digits = k;
        bool inside = true;
        for (const Index i : at) {
          const Index j = i + digits % 3 - 1;
          digits /= 3;
          inside = inside && j >= 0 && j < n;
          other = other * n + j;
        }
        if (!inside) continue;
        for (Index b = first_[other]; b >= 0; b = next_[b]) {
          if (b <= a) continue;
          const jampack::Vector<Dim> way = position[a] - position[b];
          const double reach = 0.5 * (diameter[a] + diameter[b]), distance2 = way.squaredNorm();
          if (distance2 < reach * reach && distance2 > 0)
            contacts.push_back({a, b, way / std::sqrt(distance2)});
        }
      }
      for (int i = 0; i < Dim; ++i)
        for (int side = 0; side < 2; ++side) {
          const double distance = side == 0 ? position[a][i] : edge - position[a][i];
          if (distance < 0.5 * diameter[a])
            contacts.push_back(
                {a, -1 - 2 * i - side, (side == 0 ? 1.0 : -1.0) * jampack::Vector<Dim>::Unit(i)});
        }
    }
  }

  Array<Index> first_, next_;
};

/// The contact problem of a pressed packing at rest: walls without friction that close together in one mode
/// under a constant stress (mass of the mode: that of the balls), no gaps, unit density and unit impulse.
template <int Dim, int N>
auto pressed_packing(Index n_balls, double packing_fraction, double friction, std::uint64_t seed = 1,
                     int n_steps = 400) {
  const SoftPressedBalls<Dim> balls(n_balls, packing_fraction, seed, n_steps);
  Array<jampack::InverseInertia> bodies;
  double mass = 0;
  for (const double d : balls.diameter) {
    const double m = jampack::ball_volume<Dim>(d);
    bodies.push_back({1 / m, (Dim == 3 ? 10.0 : 8.0) / (m * d * d)});
    mass += m;
  }
  // Walls at distance edge/2 (1 + s) from the centre: u_N of a contact is -edge/2 ds/dt seen from the ball.
  const double rate = -0.5 * balls.edge, mode_inverse_mass = 1 / (mass * balls.edge * balls.edge);
  Array<jampack::BallContact<Dim>> contacts;
  Eigen::VectorXd q = Eigen::VectorXd::Zero(N * balls.contacts.size());
  using Law = std::conditional_t<N == 1, jampack::Signorini, jampack::SignoriniCoulomb>;
  Array<typename Law::Contact> laws;
  for (const auto& pair : balls.contacts) {
    const bool wall = pair.antagonist < 0;
    contacts.push_back({pair.candidate, wall ? -1 : pair.antagonist, jampack::contact_frame<Dim>(pair.normal),
                        0.5 * balls.diameter[pair.candidate],
                        wall ? 0 : 0.5 * balls.diameter[pair.antagonist], wall ? rate : 0});
    if (wall) q[N * (contacts.size() - 1)] = rate * mode_inverse_mass * std::pow(balls.edge, Dim) * Dim;
    if constexpr (N == 1)
      laws.push_back({});
    else
      laws.push_back({wall ? 0.0 : friction});
  }
  return jampack::ContactProblem<jampack::RigidBallsDelassus<Dim, N>, Law>(
      jampack::RigidBallsDelassus<Dim, N>(std::move(bodies), std::move(contacts), mode_inverse_mass),
      std::move(q), std::move(laws));
}

}  // namespace jampack_tests
