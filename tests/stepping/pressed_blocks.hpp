// SPDX-License-Identifier: MIT
// Two blocks with round faces pressed on each other and pushed sideways, in plane strain: the problem of
// Cattaneo (1938) and Mindlin (1949).
#pragma once

#include <cmath>
#include <jampack/law/signorini_coulomb.hpp>
#include <jampack/material/neo_hookean.hpp>
#include <jampack/stepping/soft_step.hpp>
#include <numbers>

#include "../element/blocks.hpp"

namespace jampack_tests {

/// What the theory of two equal half-planes says (K. L. Johnson, Contact Mechanics, sections 4.2 and 7.2).
/// The parts of the displacement that are linear in the forces depend on the bodies and are left out.
struct CattaneoMindlin {
  double young, poisson, friction;
  double radius;        ///< of either face, length
  double normal_force;  ///< P, a length

  /// a, a^2 = 4 P R' / (pi E'), R' = R / 2, E' = E / (2 (1 - nu^2))
  double half_width() const {
    return std::sqrt(4 * normal_force * radius * (1 - poisson * poisson) / (std::numbers::pi * young));
  }
  double pressure(double x) const { return ellipse(half_width(), x); }
  /// c / a when Q grows for the first time, of s = Q / (mu P) in [0, 1]
  static double stick_ratio(double s) { return std::sqrt(1 - s); }
  /// Traction then: that of full slip less that of a smaller contact.
  double traction(double s, double x) const {
    const double ratio = stick_ratio(s);
    return friction * (pressure(x) - ratio * ellipse(ratio * half_width(), x));
  }
  /// How far the bodies have slid by then, beyond what is linear in Q: the compliance of a contact that
  /// sticks over |x| < c is a constant less K ln c, K = 4 (1 - nu^2) / (pi E).
  double slide(double s) const {
    const double k = 4 * (1 - poisson * poisson) / (std::numbers::pi * young);
    return s < 1 ? 0.5 * k * friction * normal_force * ((1 - s) * std::log(1 - s) + s)
                 : 0.5 * k * friction * normal_force;
  }
  /// The same at s after a turn at `turn`, on the way to the other side (Masing).
  double slide_after_turn(double turn, double s) const {
    const double sign = turn > 0 ? 1 : -1;
    return sign * (slide(std::abs(turn)) - 2 * slide(std::abs(turn - s) / 2));
  }

 private:
  /// Of the peak pressure at half-width a over any half-width.
  double ellipse(double width, double x) const {
    const double peak = 2 * normal_force / (std::numbers::pi * half_width());
    return std::abs(x) < width ? peak * std::sqrt(1 - x * x / (width * width)) : 0.0;
  }
};

/// Two unit squares, each with one face an arc, the second turned over under the first, between plates.
template <class Element, class Discretisation>
struct PressedBlocks {
  using Packing = SoftPacking<2, Element, NeoHookean>;

  static constexpr double friction = 0.3;
  double radius;  ///< of the round faces
  static constexpr NeoHookean material{.young = 1, .poisson = 0.3};
  Packing packing;
  SoftStep<Packing, SignoriniCoulomb, ProximalNewton, Discretisation> step{{friction}, {}};

  /// A block of 2 x 2n x n macros; nodes at the contact are 0.075 / n apart. Opposite a node lies the
  /// middle between two: where ridge met ridge, frames would not settle.
  static Mesh<2> block(Index n, double radius) {
    const auto face = [&](double x) { return radius - std::sqrt(radius * radius - x * x); };
    const auto graded = [](double t, double growth) { return std::sinh(growth * t) / std::sinh(growth); };
    Mesh<2> mesh = triangles(2 * n, n, [&](double s, double t) {
      const double across = 2 * s - 1, shift = (1 - across * across) / (8 * double(n));
      const double x = 0.5 * graded(across + shift, 3), low = face(x), up = graded(t, 3);
      return Vector<2>(x, low + (1 - low) * up);
    });
    add_macros(mesh, [&](const Vector<2>& a, const Vector<2>& b) {
      Vector<2> middle = (a + b) / 2;
      if (std::abs(a[1] - face(a[0])) < 1e-12 && std::abs(b[1] - face(b[0])) < 1e-12)
        middle[1] = face(middle[0]);
      return middle;
    });
    return mesh;
  }

  PressedBlocks(Index n, double face_radius)
      : radius(face_radius), packing(block(n, face_radius), material, plates<2>(2.0)) {
    packing.add(1.0, Vector<2>::Zero());
    packing.add(1.0, Vector<2>::Zero(), -Matrix<2>::Identity());
  }

  /// Presses them without friction, as the theory has it, each plate moved by `approach`. Mass keeps the
  /// blocks from slipping off each other.
  void press(double approach, Index n_steps) {
    step.law.friction = 0;
    for (Index i = 1; i <= n_steps + 1; ++i)
      settle(approach * double(std::min(i, n_steps)) / double(n_steps), 0, 10);
    step.law.friction = friction;
  }

  /// Balance with each plate moved by `approach` from where the blocks touch, under a force `shear` that is
  /// spread over each block as its mass is, to the right on the upper one. In a step this long such a force
  /// is a velocity that is stopped. Goes there in parts where it must.
  void settle(double approach, double shear, double step_length = 100) {
    const double from[] = {approach_, shear_};
    for (double reached = 0, part = 1; reached < 1;) {
      const double next = std::min(1.0, reached + part);
      approach_ = from[0] + next * (approach - from[0]);
      shear_ = from[1] + next * (shear - from[1]);
      for (Index g = 0; g < 2; ++g) {
        auto& grain = packing.grains[g];
        grain.velocity.setZero();
        grain.velocity.row(0).setConstant((g == 0 ? shear_ : -shear_) * step_length / grain.mass.sum());
      }
      const auto report = step.advance(packing, step_length, 1 - approach_, FirstGuess::rest);
      if (report.converged)
        reached = next;
      else if ((part /= 2) < 0.01)
        throw NotConverged("pressed blocks: " + report.reason);
    }
  }

  struct Node {
    double x, spacing, normal, tangential;  ///< where, length a node, forces that the upper block resists
  };
  /// What the contacts carry, from left to right.
  Array<Node> nodes() const {
    Array<Node> all;
    const auto& pairs = step.contacts.pairs;
    for (Index c = 0; c < pairs.size(); ++c) {
      const auto& contact = pairs.contact[c];
      const Vector<2> f = pairs.force(c), n = contact.normal;
      if (f.norm() == 0) continue;
      all.push_back({weighted_point(contact.own, packing.grains[contact.candidate].position)[0], 0, n.dot(f),
                     n[0] * f[1] - n[1] * f[0]});
    }
    std::sort(all.begin(), all.end(), [](const Node& p, const Node& q) { return p.x < q.x; });
    for (Index i = 0; i < all.size(); ++i) {
      const Index before = std::max<Index>(i - 1, 0), after = std::min(i + 1, all.size() - 1);
      all[i].spacing = (all[after].x - all[before].x) / double(std::max<Index>(after - before, 1));
    }
    return all;
  }

  /// Of the upper block over the lower, of their mass centres: what the shear does work on.
  double sliding() const { return packing.grains[0].centre()[0] - packing.grains[1].centre()[0]; }

 private:
  double approach_ = 0, shear_ = 0;  ///< of the last balance
};

/// What is compared with the theory, each as a share of what the theory says unless said otherwise.
struct SlipFigures {
  double half_width = 0;        ///< of the contact, measured
  double half_width_error = 0;  ///< over the half-width
  double pressure_error = 0;    ///< largest error of the force from the left edge to a point, over P
  double traction_error = 0;    ///< the same of the tangential force, over mu P, worst of all s
  double stick_error = 0;       ///< of c / a, absolute, worst of all s
  double spacing = 0;           ///< of nodes where c is, over the half-width: what it can be told to
  double loop_error = 0;        ///< of the area of the hysteresis loop
  double closing_error = 0;  ///< how far the second passage through its tip is from the first, over its width
  double normal_force = 0;
};

/// Presses, pushes up to the largest of the shares s of mu P given, then round a loop between this and minus
/// this in `n_loop` steps each way.
template <class Element, class Discretisation>
SlipFigures measure_slip(Index n, double radius, double approach, Index n_press, const Array<double>& shares,
                         Index n_loop) {
  PressedBlocks<Element, Discretisation> blocks(n, radius);
  blocks.press(approach, n_press);
  SlipFigures figures;
  for (const auto& node : blocks.nodes()) figures.normal_force += node.normal;
  const auto& material = blocks.material;
  const CattaneoMindlin theory{material.young, material.poisson, blocks.friction, blocks.radius,
                               figures.normal_force};
  const double a = theory.half_width(), most = theory.friction * theory.normal_force;
  const auto worse = [](double& worst, double error) { worst = std::max(worst, std::abs(error)); };

  // Forces from the left edge on: nodes carry half of theirs before they are reached.
  const auto force_error = [&](auto force, auto density, double unit) {
    double worst = 0, found = 0, expected = 0, from = -1.2 * a;
    for (const auto& node : blocks.nodes()) {
      constexpr int n_points = 200;
      for (int i = 0; i < n_points; ++i)
        expected += density(from + (node.x - from) * (i + 0.5) / n_points) * (node.x - from) / n_points;
      from = node.x;
      found += force(node) / 2;
      worse(worst, (found - expected) / unit);
      found += force(node) / 2;
    }
    return worst;
  };
  using Node = typename PressedBlocks<Element, Discretisation>::Node;
  const auto edge = blocks.nodes();
  figures.half_width =
      (edge.back().x - edge.front().x + edge.front().spacing / 2 + edge.back().spacing / 2) / 2;
  figures.half_width_error = figures.half_width / a - 1;
  figures.pressure_error = force_error([](const Node& node) { return node.normal; },
                                       [&](double x) { return theory.pressure(x); }, theory.normal_force);

  double slid = 0;
  for (const double s : shares) {
    blocks.settle(approach, s * most);
    // Where forces leave the cone from the inside, half way between two nodes, on the left and on the right.
    const auto nodes = blocks.nodes();
    const auto sticks = [&](const Node& node) {
      return node.tangential < 0.97 * theory.friction * node.normal;
    };
    Index first = 0, last = nodes.size() - 1;
    while (first < last && !sticks(nodes[first])) ++first;
    while (first < last && !sticks(nodes[last])) --last;
    const double c = (nodes[last].x - nodes[first].x + (nodes[last].spacing + nodes[first].spacing) / 2) / 2;
    worse(figures.stick_error, c / a - theory.stick_ratio(s));
    worse(figures.spacing, (nodes[last].spacing + nodes[first].spacing) / (2 * a));
    worse(figures.traction_error, force_error([](const Node& node) { return node.tangential; },
                                              [&](double x) { return theory.traction(s, x); }, most));
    slid = blocks.sliding();
  }
  const double turn = shares.back(), tip = slid;
  double area = 0, expected = 0, width = 0;
  double now = theory.slide(turn);
  for (const double side : {1.0, -1.0})
    for (Index i = 1; i <= n_loop; ++i) {
      const double before = side * turn * (1 - 2 * double(i - 1) / double(n_loop)),
                   s = side * turn * (1 - 2 * double(i) / double(n_loop));
      blocks.settle(approach, s * most);
      const double next = blocks.sliding(), predicted = theory.slide_after_turn(side * turn, s);
      area += 0.5 * (before + s) * most * (next - slid);
      expected += 0.5 * (before + s) * most * (predicted - now);
      slid = next;
      now = predicted;
    }
  width = std::abs(theory.slide_after_turn(turn, 0)) * 2;
  figures.loop_error = area / expected - 1;
  figures.closing_error = (slid - tip) / width;
  return figures;
}

}  // namespace jampack_tests
