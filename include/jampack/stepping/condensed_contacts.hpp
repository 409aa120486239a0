// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <jampack/stepping/augmented_balance.hpp>
#include <jampack/stepping/condensed_step.hpp>
#include <jampack/stepping/watched_contacts.hpp>
#include <utility>

namespace jampack {

/// A contact problem that a step meets (docs/theory/deformable_stage.md, section 6).
template <class Problem>
struct CondensedContacts {
  Problem problem;            ///< may use the factors of the step: not to outlive the step's next use
  Eigen::VectorXd guess;      ///< the forces so far, with which its solution begins
  Array<Index> pairs, walls;  ///< the watched contacts that take part: these pairs, then these walls
  /// Which those are, for a time when others are watched: key and face, sorted, with the place here.
  Array<std::pair<std::array<Index, 4>, Index>> places;

  template <class Contact>
  static std::array<Index, 4> identity(const Contact& contact) {
    return {contact.candidate, contact.sample, contact.antagonist, contact.face};
  }
  /// -1 for a contact that takes no part.
  template <class Contact>
  Index place(const Contact& contact) const {
    const auto wanted = identity(contact);
    const auto found = std::lower_bound(places.begin(), places.end(), wanted,
                                        [](const auto& p, const auto& key) { return p.first < key; });
    return found != places.end() && found->first == wanted ? found->second : Index{-1};
  }
};

/// The contact problem of the grains, linearised where `balance` stands, condensed on those contacts that
/// carry or whose gap is below `near` (length). Throws NotConverged where a tangent has no factor.
template <class Packing, ContactLaw Law, class Discretisation>
CondensedContacts<typename CondensedStep<Packing, Law>::Problem> condense(
    const Packing& packing, const WatchedContacts<Packing, Law, Discretisation>& watched,
    const AugmentedBalance<Packing, Law>& balance, CondensedStep<Packing, Law>& step, double near) {
  using Step = CondensedStep<Packing, Law>;
  constexpr int N = Step::N;
  Array<typename Step::Entry> entries;
  Array<Vector<Step::Dim>> force;
  const auto take = [&](const auto& set) {
    Array<Index> kept;
    for (Index c = 0; c < set.size(); ++c)
      if (set.contact[c].gap < near || !set.reaction[c].isZero(0)) {
        entries.push_back({&set.contact[c], watched.displacement(packing, set.contact[c], balance.x)});
        force.push_back(set.force(c));
        kept.push_back(c);
      }
    return kept;
  };
  Array<Index> pairs = take(watched.pairs), walls = take(watched.walls);
  Array<typename Packing::Nodal> imbalance(packing.grains.size());
  parallel_for(balance.threads, packing.grains.size(),
               [&](Index g) { imbalance[g] = balance.imbalance(packing, g); });
  step.factorise(packing, balance.tangent);
  CondensedContacts<typename Step::Problem> condensed{step.problem(packing, entries, imbalance, balance.law),
                                                      Eigen::VectorXd(N * entries.size()),
                                                      std::move(pairs),
                                                      std::move(walls),
                                                      {}};
  for (Index c = 0; c < entries.size(); ++c) {
    const auto& contact = *entries[c].contact;
    condensed.guess.template segment<N>(N * c) = Step::rows(contact) * force[c];
    condensed.problem.step.push_back(balance.contact_stiffness(packing, contact));
    condensed.places.push_back({condensed.identity(contact), c});
  }
  std::sort(condensed.places.begin(), condensed.places.end());
  return condensed;
}

/// r, along the local axes of a watched contact (a wall or not), becomes its force.
template <class Packing, ContactLaw Law, class Discretisation>
void set_force(WatchedContacts<Packing, Law, Discretisation>& watched, bool is_wall, Index c,
               const ContactVector<CondensedStep<Packing, Law>::N>& r) {
  using Step = CondensedStep<Packing, Law>;
  if (is_wall)
    watched.walls.reaction[c][0] = r[0];
  else if constexpr (Step::N == 1)
    watched.pairs.reaction[c] = r;
  else
    watched.pairs.reaction[c] = Step::rows(watched.pairs.contact[c]).transpose() * r;
}

/// The solution, which has taken the place of the guess, becomes the forces of the watched contacts.
template <class Packing, ContactLaw Law, class Discretisation>
void take_over(const CondensedContacts<typename CondensedStep<Packing, Law>::Problem>& solved,
               WatchedContacts<Packing, Law, Discretisation>& watched) {
  constexpr int N = CondensedStep<Packing, Law>::N;
  const Index n_pairs = solved.pairs.size();
  for (Index c = 0; c < n_pairs; ++c)
    set_force(watched, false, solved.pairs[c], solved.guess.template segment<N>(N * c));
  for (Index c = 0; c < solved.walls.size(); ++c)
    set_force(watched, true, solved.walls[c], solved.guess.template segment<N>(N * (n_pairs + c)));
}

}  // namespace jampack
