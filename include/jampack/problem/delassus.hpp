// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <concepts>
#include <jampack/core/array.hpp>
#include <jampack/law/friction_cone.hpp>

namespace jampack {

/// Block on the diagonal of a contact between balls: W_cc = diag(normal, tangential, tangential).
struct IsotropicBlock {
  double normal;      ///< velocity per unit of reaction, >= 0
  double tangential;  ///< the same along T1 and T2
};

/// Trace of a diagonal block with N rows.
template <int N>
double block_trace(const Eigen::Matrix<double, N, N>& block) {
  return block.trace();
}
template <int N>
double block_trace(const IsotropicBlock& block) {
  return block.normal + (N - 1) * block.tangential;
}

/// A Delassus block as a full matrix.
template <int N>
Eigen::Matrix<double, N, N> full_block(const Eigen::Matrix<double, N, N>& block) {
  return block;
}
template <int N>
Eigen::Matrix<double, N, N> full_block(const IsotropicBlock& block) {
  Eigen::Matrix<double, N, N> full = Eigen::Matrix<double, N, N>::Zero();
  full(0, 0) = block.normal;
  for (int i = 1; i < N; ++i) full(i, i) = block.tangential;
  return full;
}

/// A Delassus block with `shift` added on its diagonal.
template <int N>
Eigen::Matrix<double, N, N> shifted(const Eigen::Matrix<double, N, N>& block, double shift) {
  return block + shift * Eigen::Matrix<double, N, N>::Identity();
}
inline IsotropicBlock shifted(const IsotropicBlock& block, double shift) {
  return {block.normal + shift, block.tangential + shift};
}

/// The Delassus operator W of u = W r + q: N = n_unknowns rows a contact; vectors hold N values a contact.
///   diagonal_block(c)         W_cc,
///   apply(r, u)               u = W r,
/// and for solvers that change one contact at a time, a Motion: whatever the operator keeps up to date
/// besides r itself (velocities of bodies, say; nothing where W's rows are stored),
///   motion(r)                 the motion that r makes (may allocate; called outside of sweeps),
///   velocity(motion, r, c)    (W r)_c,
///   change(motion, c, dr)     to be called after r_c has grown by dr.
/// An operator may have for_each_body(c, visit), which visits the bodies whose motion a change of r_c changes
/// and on which (W r)_c depends: contacts without a common body can be updated at once
/// (solver/colouring.hpp).
template <class D>
concept DelassusOperator = requires(const D& delassus, Index contact, const Eigen::VectorXd& reaction,
                                    Eigen::VectorXd& velocity, typename D::Motion& motion,
                                    const ContactVector<D::n_unknowns>& change) {
  { D::n_unknowns } -> std::convertible_to<int>;
  { delassus.n_contacts() } -> std::same_as<Index>;
  { block_trace<D::n_unknowns>(delassus.diagonal_block(contact)) } -> std::same_as<double>;
  delassus.apply(reaction, velocity);
  { delassus.motion(reaction) } -> std::same_as<typename D::Motion>;
  { delassus.velocity(motion, reaction, contact) } -> std::convertible_to<ContactVector<D::n_unknowns>>;
  delassus.change(motion, contact, change);
};

}  // namespace jampack
