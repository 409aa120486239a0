// SPDX-License-Identifier: MIT
#include <cmath>
#include <jampack/analysis/contact_counterparts.hpp>
#include <jampack/analysis/contact_strain.hpp>
#include <jampack/analysis/coordination.hpp>
#include <jampack/analysis/granular_stress.hpp>
#include <jampack/analysis/hertz.hpp>
#include <jampack/analysis/merge_contact_points.hpp>
#include <jampack/packing/random.hpp>
#include <limits>
#include <numbers>

#include "../catch.hpp"

using namespace jampack;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

/// n^Dim equal grains of diameter d on a simple cubic periodic lattice of the given spacing, each pushed by
/// its neighbours with `force`. n >= 3, so that two grains touch once.
template <int Dim>
ContactNetwork<Dim> cubic_lattice(Index n, double d, double spacing, double force) {
  ContactNetwork<Dim> network;
  Index n_grains = 1;
  for (int axis = 0; axis < Dim; ++axis) n_grains *= n;
  network.diameters.assign(n_grains, d);
  network.volume = std::pow(static_cast<double>(n) * spacing, Dim);
  for (Index i = 0; i < n_grains; ++i) {
    Index stride = 1;
    for (int axis = 0; axis < Dim; ++axis, stride *= n) {
      const Index place = i / stride % n;
      const Index next = i + (place + 1 < n ? stride : -(n - 1) * stride);
      network.contacts.push_back({.candidate = i,
                                  .antagonist = next,
                                  .force = -force * Vector<Dim>::Unit(axis),
                                  .branch = -spacing * Vector<Dim>::Unit(axis)});
    }
  }
  return network;
}

/// The hexagonal lattice, one grain and its three contacts a primitive cell.
ContactNetwork<2> hexagonal_lattice(double d, double spacing, double force) {
  ContactNetwork<2> network{.diameters = {d, d, d, d}, .volume = 4 * std::sqrt(3.0) / 2 * spacing * spacing};
  for (Index i = 0; i < 4; ++i)
    for (int k = 0; k < 3; ++k) {
      const double angle = k * std::numbers::pi / 3;
      const Vector<2> n(std::cos(angle), std::sin(angle));
      network.contacts.push_back(
          {.candidate = i, .antagonist = (i + 1) % 4, .force = force * n, .branch = spacing * n});
    }
  return network;
}

/// Unit force from `antagonist` on `candidate`, for networks of which only the links matter.
ContactForce<3> link(Index candidate, Index antagonist) {
  return {.candidate = candidate,
          .antagonist = antagonist,
          .force = Vector<3>::UnitX(),
          .branch = Vector<3>::UnitX()};
}
ContactForce<3> wall_link(Index candidate, Index wall) {
  return {.candidate = candidate, .wall = wall, .force = Vector<3>::UnitX(), .branch = Vector<3>::UnitX()};
}

}  // namespace

TEST_CASE("Simple cubic lattice of Hertz spheres: P/E* = (2/3)(1 - L/d)^(3/2) d^2/L^2") {
  const double d = 1.3, spacing = 1.25, young = 7, poisson = 0.495;
  const HertzSphere sphere{d, young, poisson};
  const double f = hertz_two_spheres(sphere, sphere).force(d - spacing);
  const auto network = cubic_lattice<3>(3, d, spacing, f);
  const Matrix<3> stress = granular_stress(network);
  const double expected =
      reduced_modulus(young, poisson) * 2 / 3 * std::pow(1 - spacing / d, 1.5) * d * d / (spacing * spacing);
  CHECK_THAT(granular_pressure(network), WithinRel(expected, 1e-12));
  CHECK((stress - expected * Matrix<3>::Identity()).norm() < 1e-12 * expected);
}

TEST_CASE("Hexagonal lattice: P = sqrt(3) f / spacing, isotropic") {
  const auto network = hexagonal_lattice(1.0, 0.97, 0.4);
  const double expected = std::sqrt(3.0) * 0.4 / 0.97;
  CHECK_THAT(granular_pressure(network), WithinRel(expected, 1e-13));
  CHECK((granular_stress(network) - expected * Matrix<2>::Identity()).norm() < 1e-13);
  CHECK(coordination(network, 3).all.coordination() == 6);
}

TEMPLATE_TEST_CASE_SIG("P = phi Z sigma_l / pi holds exactly on a lattice", "", ((int Dim), Dim), 2, 3) {
  const auto network = cubic_lattice<Dim>(4, 1.3, 1.21, 0.7);
  const double n = static_cast<double>(network.n_grains());
  const double phi = n * ball_volume<Dim>(1.3) / network.volume;
  const double z = coordination(network, Dim + 1).all.coordination();
  CHECK(z == 2 * Dim);
  CHECK_THAT(polydispersity_factor(network), WithinRel(1.0, 1e-14));
  CHECK_THAT(pressure_from_contact_stress(phi, z, mean_contact_stress(network)),
             WithinRel(granular_pressure(network), 1e-13));
}

TEMPLATE_TEST_CASE_SIG("P = phi Z sigma_l / pi holds for unequal grains with the factor of their spread", "",
                       ((int Dim), Dim), 2, 3) {
  auto network = cubic_lattice<Dim>(Dim == 2 ? 100 : 22, 1.0, 0.9, 0.7);
  RandomSource random(7);
  double solid = 0;
  for (double& d : network.diameters) {
    d = random.uniform(0.8, 1.2);
    solid += ball_volume<Dim>(d);
  }
  for (auto& contact : network.contacts) contact.force *= random.uniform(0.5, 2.0);
  const double z = coordination(network, Dim + 1).all.coordination();
  CHECK_THAT(pressure_from_contact_stress(solid / network.volume, z, mean_contact_stress(network),
                                          polydispersity_factor(network)),
             WithinRel(granular_pressure(network), 1e-12));
  // <d^3> = 1 + 3 var, <d^2> = 1 + var, var = 0.4^2 / 12; 10^4 grains sample them to some 0.2 %.
  CHECK_THAT(polydispersity_factor(network), WithinRel(1 / (1 + (Dim == 2 ? 1 : 3) * 0.16 / 12), 4e-3));
}

TEST_CASE("With its wall contacts the granular stress is the pressure of the walls") {
  // Two unequal spheres in a rod between six walls, every grain in balance.
  ContactNetwork<3> network{.diameters = {1.0, 0.6}, .volume = 1.6 * 1.0 * 1.0};
  const double push = 0.4, side = 0.1;
  const auto wall = [&](Index grain, Index w, const Vector<3>& force, double distance) {
    network.contacts.push_back(
        {.candidate = grain, .wall = w, .force = force, .branch = distance * force.normalized()});
  };
  network.contacts.push_back({.candidate = 0,
                              .antagonist = 1,
                              .force = -push * Vector<3>::UnitX(),
                              .branch = -0.8 * Vector<3>::UnitX()});
  wall(0, 0, push * Vector<3>::UnitX(), 0.5);
  wall(1, 1, -push * Vector<3>::UnitX(), 0.3);
  for (int axis = 1; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0})
      wall(0, 2 * axis + (sign < 0), sign * side * Vector<3>::Unit(axis), 0.5);
  const Matrix<3> stress = granular_stress(network);
  CHECK_THAT(stress(0, 0), WithinRel(push / (1.0 * 1.0), 1e-13));
  CHECK_THAT(stress(1, 1), WithinRel(side / (1.6 * 1.0), 1e-13));
  CHECK_THAT(stress(2, 2), WithinRel(side / (1.6 * 1.0), 1e-13));
  CHECK_THAT(granular_pressure(network), WithinRel((push + 2 * side / 1.6) / 3, 1e-13));

  const Coordination z = coordination(network, 2);
  CHECK(z.all.n_grain_contacts == 1);
  CHECK(z.all.n_wall_contacts == 6);
  CHECK(z.all.coordination() == 1);
  CHECK(z.all.coordination_with_walls() == 4);
}

TEMPLATE_TEST_CASE_SIG("Gamma = D for an affine strain", "", ((int Dim), Dim), 2, 3) {
  const double excess = 1e-5;
  const auto network = cubic_lattice<Dim>(3, 1.0, 1 - excess, 0.1);
  const double strain = -Dim * std::log(1 - excess);
  CHECK_THAT(strain / contact_strain(network), WithinRel(Dim, 1e-4));
  CHECK_THAT(contact_strain(network), WithinRel(excess, 1e-9));
}

TEST_CASE("Contact strain is signed, and walls and idle contacts are left out") {
  ContactNetwork<2> network{.diameters = {1.0, 2.0}, .volume = 1};
  const auto pair = [](double force, double distance) {
    return ContactForce<2>{.candidate = 0, .antagonist = 1, .force = {force, 0}, .branch = {distance, 0}};
  };
  CHECK(contact_strain(network) == 0);
  network.contacts = {pair(1, 1.6)};
  CHECK_THAT(contact_strain(network), WithinRel(-0.1 / 1.5, 1e-12));
  network.contacts.push_back(pair(0, 0.1));
  network.contacts.push_back({.candidate = 0, .wall = 0, .force = {1, 0}, .branch = {0.1, 0}});
  CHECK_THAT(contact_strain(network), WithinRel(-0.1 / 1.5, 1e-12));
  network.contacts.push_back(pair(0.5, 1.2));
  CHECK_THAT(contact_strain(network), WithinRel(0.1 / 1.5, 1e-12));
  CHECK_THAT(contact_strain(network, 0.75), WithinRel(-0.1 / 1.5, 1e-12));
}

TEST_CASE("The mean contact stress leaves walls and weak contacts out") {
  auto network = cubic_lattice<3>(3, 1.3, 1.25, 0.7);
  const double bulk = 0.7 * 1.25 / (1.3 * 1.3 * 1.3);
  network.contacts.push_back({.candidate = 0, .wall = 0, .force = {9, 0, 0}, .branch = {0.6, 0, 0}});
  CHECK_THAT(mean_contact_stress(network), WithinRel(bulk, 1e-12));
  network.contacts.push_back({.candidate = 0, .antagonist = 13, .force = {0.1, 0, 0}, .branch = {1, 0, 0}});
  CHECK_THAT(mean_contact_stress(network, 0.2), WithinRel(bulk, 1e-12));
  CHECK(mean_contact_stress(network) < 0.999 * bulk);
}

TEST_CASE("A contact counts above 1e-4 P <d>^(D-1)") {
  auto network = cubic_lattice<3>(3, 1.3, 1.25, 0.7);
  const double threshold = contact_threshold(network);
  CHECK_THAT(threshold, WithinRel(1e-4 * granular_pressure(network) * 1.3 * 1.3, 1e-12));
  const Index n_contacts = network.contacts.size();
  for (const double factor : {0.999, 1.001}) {
    auto more = network;
    more.contacts.push_back(
        {.candidate = 0, .antagonist = 13, .force = {0, 0, factor * threshold}, .branch = Vector<3>::Zero()});
    CHECK(coordination(more, 4).all.n_grain_contacts == n_contacts + (factor > 1));
  }
}

TEST_CASE("Removing a rattler may leave another: a chain hanging on a held cluster goes entirely") {
  // Grains 0-4 all touch one another (Z = 4); 5-6-7 hang on 4 as a chain; 8 touches nothing.
  ContactNetwork<3> network{.diameters = Array<double>(9, 1.0), .volume = 100};
  for (Index i = 0; i < 5; ++i)
    for (Index j = 0; j < i; ++j) network.contacts.push_back(link(i, j));
  for (Index i = 4; i < 7; ++i) network.contacts.push_back(link(i, i + 1));
  const auto frictionless = find_rattlers(network, contacts_to_hold<3>(false));
  const auto frictional = find_rattlers(network, contacts_to_hold<3>(true));
  CHECK(frictionless == Array<char>{0, 0, 0, 0, 0, 1, 1, 1, 1});
  CHECK(frictional == frictionless);

  const Coordination z = coordination(network, 2);
  CHECK(z.all.n_grains == 9);
  CHECK_THAT(z.all.coordination(), WithinRel(2 * 13 / 9.0, 1e-13));
  CHECK(z.held.n_grains == 5);
  CHECK(z.held.n_grain_contacts == 10);
  CHECK(z.held.coordination() == 4);
}

TEST_CASE("Friction holds a grain with two contacts, and wall contacts hold as well") {
  ContactNetwork<3> network{.diameters = Array<double>(2, 1.0), .volume = 10};
  network.contacts = {wall_link(0, 0), link(0, 1), wall_link(1, 1)};
  CHECK(find_rattlers(network, contacts_to_hold<3>(true)) == Array<char>{0, 0});
  CHECK(find_rattlers(network, contacts_to_hold<3>(false)) == Array<char>{1, 1});
  for (Index w = 2; w < 4; ++w)
    for (Index i = 0; i < 2; ++i) network.contacts.push_back(wall_link(i, w));
  CHECK(find_rattlers(network, contacts_to_hold<3>(false)) == Array<char>{0, 0});
  // Without the force between them both lose one contact, and are rattlers again.
  network.contacts[1].force.setZero();
  CHECK(find_rattlers(network, contacts_to_hold<3>(false)) == Array<char>{1, 1});
  CHECK(coordination(network, 4).held.coordination() == 0);
}

TEST_CASE("Isostatic count: one sphere in a closed corner of walls") {
  // N_gg + N_w = D N_nr + 1 with one driven wall mode: four walls of a tetrahedron hold one sphere.
  ContactNetwork<3> network{.diameters = Array<double>(1, 1.0), .volume = 10};
  for (Index w = 0; w < 4; ++w) network.contacts.push_back(wall_link(0, w));
  const Coordination z = coordination(network, contacts_to_hold<3>(false));
  CHECK(z.held.n_grain_contacts + z.held.n_wall_contacts == 3 * z.held.n_grains + 1);
}

TEST_CASE("Contact points of one pair become one contact with the same granular stress") {
  Array<ContactForce<3>> points;
  const auto add = [&](Index a, Index b, Index w, const Vector<3>& f, const Vector<3>& branch) {
    points.push_back({.candidate = a, .antagonist = b, .wall = w, .force = f, .branch = branch});
  };
  const Vector<3> branch01(0.9, 0.1, 0);
  add(0, 1, -1, {1, 0.2, 0}, branch01);
  add(0, -1, 3, {0, 0, 2}, {0.1, 0, 0.5});
  add(1, 0, -1, {-0.5, 0.1, 0.3}, -branch01);  // the other half-pass
  add(0, -1, 3, {0, 0, 1}, {-0.3, 0.1, 0.49});
  add(1, -1, 3, {0, 0, 1}, {0, 0, 0.5});
  add(0, -1, 4, {0, 0, 0}, {0, 0.4, 0});
  add(0, -1, 4, {0, 0, 0}, {0, 0.6, 0});
  const auto merged = merge_contact_points(points);
  REQUIRE(merged.size() == 4);
  CHECK(merged[0].candidate == 0);
  CHECK(merged[0].antagonist == 1);
  CHECK((merged[0].force - Vector<3>(1.5, 0.1, -0.3)).norm() < 1e-15);
  CHECK((merged[0].branch - branch01).norm() < 1e-15);
  CHECK(merged[1].wall == 3);
  CHECK((merged[1].force - Vector<3>(0, 0, 3)).norm() < 1e-15);
  CHECK(merged[2].candidate == 1);
  CHECK((merged[3].branch - Vector<3>(0, 0.5, 0)).norm() < 1e-15);

  const ContactNetwork<3> by_points{{1, 1}, points, 2.0}, by_contacts{{1, 1}, merged, 2.0};
  CHECK((granular_stress(by_points) - granular_stress(by_contacts)).norm() < 1e-15);
}

TEST_CASE("Impossible networks are refused") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const ContactNetwork<3> good{.diameters = {1, 1}, .contacts = {link(0, 1)}, .volume = 1};
  CHECK_NOTHROW(granular_stress(good));
  const auto refused = [&](auto change) {
    auto bad = good;
    change(bad);
    CHECK_THROWS_AS(granular_stress(bad), InvalidInput);
    CHECK_THROWS_AS(contact_strain(bad), InvalidInput);
    CHECK_THROWS_AS(find_rattlers(bad, 2), InvalidInput);
  };
  refused([](auto& n) { n.volume = 0; });
  refused([&](auto& n) { n.volume = nan; });
  refused([](auto& n) { n.diameters[0] = -1; });
  refused([](auto& n) { n.diameters.clear(); });
  refused([](auto& n) { n.contacts[0].candidate = 2; });
  refused([](auto& n) { n.contacts[0].antagonist = 2; });
  refused([](auto& n) { n.contacts[0].antagonist = -1; });
  refused([](auto& n) { n.contacts[0].wall = 0; });
  refused([&](auto& n) { n.contacts[0].force[1] = nan; });
}

TEST_CASE("Contacts of two models of a packing are matched by their bodies, in either order") {
  ContactNetwork<3> network{.diameters = Array<double>(3, 1.0), .volume = 10};
  network.contacts = {link(0, 1), wall_link(1, 0), link(1, 2), wall_link(0, 1), wall_link(2, 0)};
  auto other = network;
  other.contacts = {wall_link(2, 0), link(2, 1), link(1, 0), wall_link(0, 2), wall_link(1, 0)};
  CHECK(contact_counterparts(network, other) == Array<Index>{2, 4, 1, -1, 0});
  CHECK(contact_counterparts(other, network) == Array<Index>{4, 2, 0, -1, 1});
  other.contacts.push_back(link(1, 2));
  CHECK_THROWS_WITH(contact_counterparts(network, other), jampack_tests::contains("same bodies"));
  other = {.diameters = {1.0}, .volume = 10};
  CHECK_THROWS_WITH(contact_counterparts(network, other), jampack_tests::contains("same grains"));
}

TEST_CASE("The approach of a contact is shared by the diameters that bear it") {
  ContactNetwork<2> network{.diameters = {1.0, 2.0}, .volume = 1};
  const ContactForce<2> pair{.candidate = 1, .antagonist = 0, .force = {3, 4}, .branch = {1.2, 0}};
  CHECK_THAT(contact_approach(network, pair), WithinAbs(0.3, 1e-14));
  CHECK_THAT(approach_over_diameter(network, pair), WithinAbs(0.1, 1e-14));
  CHECK_THAT(normal_force(pair), WithinAbs(3, 1e-14));
  // The force of a wall acts beside the point below the centre: only the distance to the wall counts.
  const ContactForce<2> wall{.candidate = 1, .wall = 0, .force = {0, -2}, .branch = {0.1, -0.96}};
  CHECK_THAT(contact_approach(network, wall), WithinAbs(0.04, 1e-14));
  CHECK_THAT(approach_over_diameter(network, wall), WithinAbs(0.02, 1e-14));
  CHECK_THAT(normal_force(wall), WithinAbs(2, 1e-14));
}
