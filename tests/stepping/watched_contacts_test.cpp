// SPDX-License-Identifier: MIT
#include <jampack/element/macro_simplex.hpp>
#include <jampack/law/signorini_coulomb.hpp>
#include <jampack/material/neo_hookean.hpp>
#include <jampack/mesh/disk_mesh.hpp>
#include <jampack/stepping/watched_contacts.hpp>

#include "../catch.hpp"

using namespace jampack;

namespace {

using Rubber = SoftPacking<2, MacroSimplex<2>, NeoHookean>;
using Contacts = WatchedContacts<Rubber, SignoriniCoulomb>;
constexpr double reach = 0.05;

/// One disk on top of another, whose topmost node stands out by `tooth`.
Rubber disk_on_disk(double tooth) {
  Rubber packing(disk_mesh(64), NeoHookean{.young = 1, .poisson = 0.45}, container(centred_cube<2>(4.0)));
  packing.add(1.0, {0, -0.5});
  packing.add(0.9, {0, 0.4495 + tooth});
  auto& below = packing.grains[0].position;
  Index top = 0;
  for (const Index i : packing.model->boundary.nodes)
    if (below(1, i) > below(1, top)) top = i;
  below(1, top) += tooth;
  return packing;
}

/// The contacts between the disks after the upper one has slid to and fro so many times.
Index n_left(const Rubber& packing, Contacts& contacts, int times) {
  Array<Rubber::Nodal> x{packing.grains[0].position, packing.grains[1].position};
  contacts.find(packing, x, reach, SampleSet::all, Threads{});
  for (int i = 0; i < times; ++i) {
    x[1].row(0).array() += i % 2 == 0 ? 0.05 : -0.05;
    contacts.refresh(packing, x, reach, Threads{});
  }
  return contacts.pairs.size();
}

}  // namespace

TEST_CASE("a sample whose gap jumps up and down is set aside until the next step") {
  const auto packing = disk_on_disk(0.02);
  Contacts contacts;
  const Index all = n_left(packing, contacts, 0);
  CHECK(n_left(packing, contacts, 2) == all);
  contacts.begin_step();
  const Index left = n_left(packing, contacts, 8);
  CHECK(left < all);
  CHECK(contacts.any_set_aside());
  CHECK(left > all / 2);
  CHECK(n_left(packing, contacts, 0) == left);
  contacts.begin_step();
  CHECK(n_left(packing, contacts, 0) == all);
}

TEST_CASE("no sample is set aside because a grain slides to and fro") {
  const auto packing = disk_on_disk(0);
  Contacts contacts;
  const Index all = n_left(packing, contacts, 0);
  REQUIRE(all > 0);
  CHECK(n_left(packing, contacts, 40) == all);
  CHECK_FALSE(contacts.any_set_aside());
}
