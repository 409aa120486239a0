// SPDX-License-Identifier: MIT
#include <jampack/element/macro_simplex.hpp>
#include <jampack/law/signorini_coulomb.hpp>
#include <jampack/material/neo_hookean.hpp>
#include <jampack/mesh/disk_mesh.hpp>
#include <jampack/stepping/watched_contacts.hpp>
#include <map>

#include "../catch.hpp"

using namespace jampack;

namespace {

using Rubber = SoftPacking<2, MacroSimplex<2>, NeoHookean>;
using Contacts = WatchedContacts<Rubber, SignoriniCoulomb>;
constexpr double reach = 0.05;

/// A disk on top of another, from which a corner of its boundary is pushed in by `dent`.
Rubber disk_on_disk(double dent) {
  Rubber packing(disk_mesh(64), NeoHookean{.young = 1, .poisson = 0.45}, container(centred_cube<2>(4.0)));
  packing.add(1.0, {0, -0.5});
  packing.add(0.9, {0, 0.4495 - dent});
  auto& below = packing.grains[0].position;
  Index top = packing.model->boundary.faces[0].node[0];
  for (const auto& face : packing.model->boundary.faces)
    for (const Index i : {face.node[0], face.node[1]})
      if (below(1, i) > below(1, top)) top = i;
  packing.grains[1].position.row(0).array() += below(0, top);
  below(1, top) -= dent;
  return packing;
}

/// By sample of the upper disk: how many faces of the lower one hold it, and with what force.
struct Held {
  Index faces = 0;
  Vector<2> force = Vector<2>::Zero();
};
std::map<Index, Held> held_samples(const Contacts& contacts) {
  std::map<Index, Held> held;
  for (Index c = 0; c < contacts.pairs.size(); ++c)
    if (contacts.pairs.contact[c].candidate == 1) {
      auto& sample = held[contacts.pairs.contact[c].sample];
      ++sample.faces;
      sample.force += contacts.pairs.force(c);
    }
  return held;
}

}  // namespace

TEST_CASE("in a dent samples are held at both of its sides, and keep their forces as they cross it") {
  const auto packing = disk_on_disk(0.02);
  Contacts contacts;
  Array<Rubber::Nodal> x{packing.grains[0].position, packing.grains[1].position};
  contacts.find(packing, x, reach, SampleSet::all, Threads{});
  const auto first = held_samples(contacts);
  const auto most = [](const auto& held) {
    Index faces = 0;
    for (const auto& [sample, of] : held) faces = std::max(faces, of.faces);
    return faces;
  };
  CHECK(most(first) == 2);
  CHECK(std::any_of(first.begin(), first.end(), [](const auto& h) { return h.second.faces == 1; }));

  std::map<std::pair<Index, Index>, Vector<2>> of_face;
  for (Index c = 0; c < contacts.pairs.size(); ++c) {
    const auto& contact = contacts.pairs.contact[c];
    const Vector<2> force(double(contact.sample), double(contact.face));
    contacts.pairs.reaction[c] = force;
    if (contact.candidate == 1) of_face[{contact.sample, contact.face}] = force;
  }
  const auto before = held_samples(contacts);
  Index n_kept = 0, n_crossed = 0;
  for (const double slide : {0.004, -0.008, 0.004}) {
    x[1].row(0).array() += slide;
    contacts.refresh(packing, x, reach, Threads{});
    for (const auto& [sample, held] : held_samples(contacts)) CHECK(held.force == before.at(sample).force);
    for (Index c = 0; c < contacts.pairs.size(); ++c) {
      const auto& contact = contacts.pairs.contact[c];
      const auto was = of_face.find({contact.sample, contact.face});
      const bool two = c + 1 < contacts.pairs.size() && contacts.pairs.contact[c + 1].key() == contact.key();
      if (contact.candidate != 1 || !two || was == of_face.end()) continue;
      if (before.at(contact.sample).faces != 2) continue;
      ++n_kept;
      CHECK(contacts.pairs.reaction[c] == was->second);
      n_crossed += contact.face != of_face.lower_bound({contact.sample, 0})->first.second;
    }
  }
  CHECK(n_kept > 0);
  CHECK(n_crossed > 0);
}

TEST_CASE("contacts are the same however often a grain slides to and fro") {
  const auto packing = disk_on_disk(0);
  Contacts contacts;
  Array<Rubber::Nodal> x{packing.grains[0].position, packing.grains[1].position};
  contacts.find(packing, x, reach, SampleSet::all, Threads{});
  const Index all = contacts.pairs.size();
  REQUIRE(all > 0);
  for (int i = 0; i < 40; ++i) {
    x[1].row(0).array() += i % 2 == 0 ? 0.05 : -0.05;
    contacts.refresh(packing, x, reach, Threads{});
  }
  CHECK(contacts.pairs.size() == all);
}
