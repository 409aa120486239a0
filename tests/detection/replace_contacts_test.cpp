// SPDX-License-Identifier: MIT
#include <jampack/detection/surface_detection.hpp>

#include "../catch.hpp"

using namespace jampack;

namespace {

/// Of sample `sample`, above or beside this face.
SurfaceContact<2> contact(Index sample, Index face) {
  SurfaceContact<2> c;
  c.candidate = 0;
  c.antagonist = 1;
  c.sample = sample;
  c.face = face;
  return c;
}

}  // namespace

TEST_CASE("a force stays with the face it is on, and goes with the sample where that face is left") {
  SurfaceContacts<2, 2> set;
  set.contact = {contact(3, 0), contact(3, 1), contact(4, 2), contact(5, 7), contact(5, 8)};
  set.reaction = {{1, 2}, {3, 4}, {5, 6}, {0, 7}, {8, 0}};
  // Sample 3 has crossed the crease, 4 has left its face, 5 is gone though it carries, 6 is new.
  replace_contacts(set, {contact(3, 1), contact(3, 0), contact(4, 9), contact(4, 8), contact(6, 1)});
  REQUIRE(set.size() == 7);
  CHECK(set.reaction[0] == Vector<2>(3, 4));
  CHECK(set.reaction[1] == Vector<2>(1, 2));
  CHECK(set.contact[2].face == 9);
  CHECK(set.reaction[2] == Vector<2>(5, 6));
  CHECK(set.reaction[3] == Vector<2>(0, 0));
  CHECK(set.contact[4].face == 7);
  CHECK(set.reaction[4] == Vector<2>(0, 7));
  CHECK(set.reaction[5] == Vector<2>(8, 0));
  CHECK(set.contact[6].sample == 6);
  CHECK(set.reaction[6] == Vector<2>(0, 0));

  // What goes and carries nothing is gone, on all of its faces.
  for (auto& r : set.reaction) r.setZero();
  set.reaction[1] = {0, 1};
  replace_contacts(set, Array<SurfaceContact<2>>{});
  REQUIRE(set.size() == 2);
  CHECK(set.contact[0].face == 1);
  CHECK(set.contact[1].face == 0);
}

TEST_CASE("a sample that is kept for its force does not part the next one from its own") {
  SurfaceContacts<2, 2> set;
  set.contact = {contact(2, 0), contact(3, 1), contact(3, 2)};
  set.reaction = {{1, 0}, {2, 0}, {0, 3}};
  CHECK(replace_contacts(set, {contact(3, 2), contact(3, 1)}) == Array<Index>{0});
  REQUIRE(set.size() == 3);
  CHECK(set.contact[0].sample == 2);
  CHECK(set.reaction[0] == Vector<2>(1, 0));
  CHECK(set.contact[1].face == 2);
  CHECK(set.reaction[1] == Vector<2>(0, 3));
  CHECK(set.reaction[2] == Vector<2>(2, 0));
}
