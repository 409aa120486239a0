// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/core/error.hpp>
#include <jampack/law/contact_law.hpp>
#include <jampack/law/signorini_coulomb.hpp>
#include <jampack/problem/delassus.hpp>
#include <string>
#include <utility>

namespace jampack {

/// One contact problem: find reactions r and velocities u with u = W r + q and, at every contact, the law
/// between r and u. Solvers take it by const reference; it knows nothing of where it came from.
template <DelassusOperator Delassus, ContactLaw Law = SignoriniCoulomb>
struct ContactProblem {
  using DelassusType = Delassus;
  using LawType = Law;
  using LocalLaw = typename Law::Contact;
  static constexpr int n_unknowns = Delassus::n_unknowns;  ///< unknowns a contact

  Delassus delassus;              ///< W
  Eigen::VectorXd free_velocity;  ///< q, n_unknowns values a contact: the velocity without reactions
  Array<LocalLaw> law;            ///< one a contact
  /// Step of the natural map at each contact, > 0, where whoever made the problem knows a better one than
  /// N / tr W_cc; empty otherwise.
  Array<double> step = {};

  /// Throws InvalidInput if the sizes do not fit, q or W_cc is not finite or friction is negative or NaN.
  ContactProblem(Delassus w, Eigen::VectorXd q, Array<LocalLaw> laws)
      : delassus(std::move(w)), free_velocity(std::move(q)), law(std::move(laws)) {
    require(law.size() == delassus.n_contacts() && free_velocity.size() == n_unknowns * law.size(),
            "contact problem: W has " + std::to_string(delassus.n_contacts()) + " contacts of " +
                std::to_string(n_unknowns) + " unknowns, q " + std::to_string(free_velocity.size()) +
                " values, laws are given for " + std::to_string(law.size()) + " contacts");
    require(free_velocity.allFinite(), "contact problem: the free velocity q is not finite");
    for (Index c = 0; c < law.size(); ++c) {
      const double friction = law[c].friction;
      require(friction >= 0 && friction < 1e300,
              "contact problem: friction at contact " + std::to_string(c) + " must be finite and >= 0");
      require(full_block<n_unknowns>(delassus.diagonal_block(c)).allFinite(),
              "contact problem: W is not finite at contact " + std::to_string(c));
    }
  }

  Index n_contacts() const { return law.size(); }
};

}  // namespace jampack
