// SPDX-License-Identifier: MIT
#pragma once

#include <concepts>

namespace jampack {

/// What a contact of a law needs to say about itself, one value a contact:
///   friction               Coulomb's coefficient, >= 0 (a static zero where there is none),
///   compliance(r_N)        normal velocity c(r_N) >= 0 that the reaction r_N >= 0 adds to u_N before the
///                          unilateral condition: 0 <= r_N  _|_  u_N + c(r_N) >= 0. c(0) = 0, increasing,
///   compliance_slope(r_N)  its derivative at r_N > 0,
///   is_compliant           whether c can differ from zero (the code for it is compiled only then).
template <class C>
concept LocalContactLaw = requires(const C contact, double reaction) {
  { contact.friction } -> std::convertible_to<double>;
  { contact.compliance(reaction) } -> std::same_as<double>;
  { contact.compliance_slope(reaction) } -> std::same_as<double>;
  { C::is_compliant } -> std::convertible_to<bool>;
};

/// A contact law is a small value type that carries its own parameters. It fixes how many unknowns a contact
/// has in each dimension and the type that stores what one contact needs.
template <class L>
concept ContactLaw = requires {
  typename L::Contact;
  { L::n_unknowns(2) } -> std::same_as<int>;
  { L::n_unknowns(3) } -> std::same_as<int>;
  requires LocalContactLaw<typename L::Contact>;
  requires(L::n_unknowns(2) == 1 || L::n_unknowns(2) == 2);
  requires(L::n_unknowns(3) == 1 || L::n_unknowns(3) == 3);
};

/// Unknowns a contact carries under a law.
template <ContactLaw Law, int Dim>
inline constexpr int n_contact_unknowns = Law::n_unknowns(Dim);

}  // namespace jampack
