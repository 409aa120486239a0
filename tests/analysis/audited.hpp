// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/analysis/audit.hpp>
#include <jampack/element/macro_simplex.hpp>
#include <jampack/material/neo_hookean.hpp>

#include "../catch.hpp"

namespace jampack_tests {

template <int Dim>
jampack::AuditReport audit_of(const jampack::StoredState<Dim>& state) {
  return jampack::audit<jampack::MacroSimplex<Dim>, jampack::NeoHookean>(state);
}

/// Every row of the report within its bound.
inline void check_all_good(const jampack::AuditReport& report) {
  for (const auto& row : report.rows()) {
    INFO(row.name << " = " << row.value);
    CHECK(row.is_good);
  }
}

template <int Dim>
jampack::StoredContact<Dim>& strongest(jampack::Array<jampack::StoredContact<Dim>>& contacts) {
  jampack::Index best = 0;
  for (jampack::Index c = 0; c < contacts.size(); ++c)
    if (contacts[c].reaction.norm() > contacts[best].reaction.norm()) best = c;
  REQUIRE(contacts[best].reaction.norm() > 0);
  return contacts[best];
}

}  // namespace jampack_tests
