// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/core/parallel.hpp>
#include <jampack/geometry/frame.hpp>
#include <jampack/law/signorini.hpp>
#include <jampack/problem/residual.hpp>
#include <jampack/stepping/watched_contacts.hpp>

namespace jampack {

/// Balance of momentum over one step under contact forces, and the potential of the augmented Lagrangian that
/// judges moves towards it (docs/theory/deformable_stage.md, eq. 6 to 8).
template <class Packing, ContactLaw Law>
class AugmentedBalance {
 public:
  static constexpr int Dim = Packing::dimension;
  static constexpr int N = n_contact_unknowns<Law, Dim>;
  using Nodal = typename Packing::Nodal;

  Law law;
  Threads threads;
  double theta = 1;
  double least_force = 0;  ///< forces are measured against no less
  double penalty = 0;      ///< of the potential, in units of contact_stiffness()

  Array<Nodal> x;                   ///< positions at the end of the step
  Array<Nodal> force;               ///< internal, at x
  Array<BlockMatrix<Dim>> tangent;  ///< positive definite stand-in for theta K + M / (theta h^2)

  Array<ContactVector<N>> pair_force;  ///< contact forces at x
  Array<ContactVector<1>> wall_force;
  Array<Nodal> residual;        ///< of the balance of momentum, as forces
  double residual_norm = 0;     ///< its norm
  double force_scale = 0;       ///< norm of the nodal contact forces
  double contact_residual = 0;  ///< of the contact law, steps N / tr W_cc: the scaled residual
  double surface_residual = 0;  ///< the same with the stiffness of the surface alone: larger
  double round_off = 0;         ///< what residual_norm cannot fall below

  /// Starts a step of duration h from the packing's state; the first guess for its end is that state, or
  /// where the grains would fly. False when no shape without inverted cells is at hand.
  bool begin(const Packing& packing, double h, bool fly = true) {
    h_ = h;
    const Index n = packing.grains.size();
    for (auto* nodal : {&x, &force, &residual, &old_force_, &contact_nodal_}) nodal->resize(n);
    tangent.resize(n);
    for (Index g = 0; g < n; ++g) {
      const auto& grain = packing.grains[g];
      x[g] = grain.position;
      if (theta < 1) grain.internal_force(*packing.model, grain.position, old_force_[g]);
      if (!fly) continue;
      // What flies far in the step is not expected to get there.
      const double flight = h * std::sqrt(grain.velocity.colwise().squaredNorm().maxCoeff());
      const double most = 0.02 * grain.diameter;
      x[g] += h * std::min(1.0, most / std::max(flight, most)) * grain.velocity;
    }
    if (linearise(packing)) return true;
    for (Index g = 0; g < n; ++g) x[g] = packing.grains[g].position;
    return linearise(packing);
  }

  /// Internal forces and tangents at x; false when a cell is inverted.
  bool linearise(const Packing& packing) {
    return for_each_grain(packing, [&](Index g) {
      const bool good =
          packing.grains[g].internal_force_and_definite_tangent(*packing.model, x[g], force[g], tangent[g]);
      add_inertia(packing, g, tangent[g]);
      return good;
    });
  }

  /// Internal forces at x, and theta K + M / (theta h^2) with the exact K, which need not be positive
  /// definite; false when a cell is inverted. `tangent` stays what it was.
  bool linearise_exactly(const Packing& packing, Array<BlockMatrix<Dim>>& exact) {
    exact.resize(x.size());
    return for_each_grain(packing, [&](Index g) {
      const bool good =
          packing.grains[g].internal_force_and_tangent(*packing.model, x[g], force[g], exact[g]);
      add_inertia(packing, g, exact[g]);
      return good;
    });
  }

  /// What the contact forces, the multipliers within their cones, leave of balance and contact law at x;
  /// writes the gaps of the contacts.
  template <class Contacts>
  void evaluate(const Packing& packing, Contacts& contacts) {
    double error = 0, surface_error = 0;
    const auto visit = [&](auto& set, auto& trial, const auto& contact_law) {
      constexpr int M = std::decay_t<decltype(trial[0])>::RowsAtCompileTime;
      trial.resize(set.size());
      for (Index c = 0; c < set.size(); ++c) {
        auto& contact = set.contact[c];
        const Vector<Dim> s = contacts.displacement(packing, contact, x);
        contact.gap = contact.normal.dot(s);
        const Vector<Dim> held = within_cone(set.force(c), contact.normal, contact_law.friction);
        if constexpr (M == 1)
          trial[c][0] = contact.normal.dot(held);
        else
          trial[c] = held;
        const Eigen::Matrix<double, M, Dim> axes = contact_frame<Dim>(contact.normal).template topRows<M>();
        const ContactVector<M> r = axes * held, u = axes * s;
        const double k = contact_stiffness(packing, contact), soft = 1 / k + mobility(packing, contact);
        error += natural_map<M>(contact_law, r, u, 1 / soft).squaredNorm();
        surface_error += natural_map<M>(contact_law, r, u, k).squaredNorm();
      }
    };
    visit(contacts.pairs, pair_force, law);
    visit(contacts.walls, wall_force, Signorini{});
    double size = 0;
    for (const auto& r : pair_force) size += r.squaredNorm();
    for (const auto& r : wall_force) size += r.squaredNorm();
    contact_residual = std::sqrt(error) / std::max(std::sqrt(size), least_force);
    surface_residual = std::sqrt(surface_error) / std::max(std::sqrt(size), least_force);
    balance(packing, contacts);
  }

  bool balanced(double tolerance, double scaled_tolerance, double surface_tolerance) const {
    return residual_norm <= tolerance * force_scale + round_off && contact_residual <= scaled_tolerance &&
           surface_residual <= surface_tolerance;
  }
  double equilibrium_residual() const { return residual_norm / force_scale; }

  /// The forces become the multipliers.
  template <class Contacts>
  void accept_forces(Contacts& contacts) const {
    contacts.pairs.reaction = pair_force;
    contacts.walls.reaction = wall_force;
  }

  /// Holds the friction bounds of potential() at these forces.
  template <class Contacts>
  void hold_bounds(const Contacts& contacts, const Array<ContactVector<N>>& of_pairs) {
    bound_.assign(contacts.pairs.size(), 0.0);
    if constexpr (N > 1)
      for (Index c = 0; c < bound_.size(); ++c)
        bound_[c] = law.friction * std::max(0.0, contacts.pairs.contact[c].normal.dot(of_pairs[c]));
  }

  /// What balance at the multipliers and friction bounds held minimises (eq. 8): its gradient is the
  /// residual where the bounds are those of the present forces. +infinity where a cell is inverted.
  template <class Contacts>
  double potential(const Packing& packing, const Contacts& contacts) const {
    Array<double> of_grain(packing.grains.size());
    parallel_for(threads, packing.grains.size(), [&](Index g) {
      const auto& grain = packing.grains[g];
      const Nodal dx = x[g] - grain.position - h_ * grain.velocity;
      of_grain[g] = theta * grain.energy(*packing.model, x[g]) +
                    0.5 / (theta * h_ * h_) * dx.colwise().squaredNorm().dot(grain.mass);
      if (theta < 1) of_grain[g] += (1 - theta) * old_force_[g].cwiseProduct(x[g]).sum();
    });
    double sum = 0;
    for (const double energy : of_grain) sum += energy;
    const auto add = [&](const auto& set, Index c, double bound) {
      const auto& contact = set.contact[c];
      const double rho = penalty * contact_stiffness(packing, contact);
      const Vector<Dim> trial = set.force(c) - rho * contacts.displacement(packing, contact, x);
      const double along = contact.normal.dot(trial), pressing = std::max(0.0, along);
      const double tangential = (trial - along * contact.normal).norm();
      const double held = std::min(tangential, bound);
      sum += (0.5 * pressing * pressing + held * (tangential - 0.5 * held)) / rho;
    };
    for (Index c = 0; c < contacts.pairs.size(); ++c) add(contacts.pairs, c, bound_[c]);
    for (Index c = 0; c < contacts.walls.size(); ++c) add(contacts.walls, c, 0.0);
    return sum;
  }

  /// What resists a force at one sample in a step: a surface layer one edge thick under the sample's area,
  /// and the mass of a node.
  double contact_stiffness(const Packing& packing, const SurfaceContact<Dim>& contact) const {
    const auto& boundary = packing.model->boundary;
    const auto& grain = packing.grains[contact.candidate];
    const double size = Dim == 2 ? 1.0 : grain.diameter;
    const double layer = 8 * packing.model->material.young * boundary.node_area / boundary.edge_length * size;
    return layer + grain.mass.mean() / (theta * h_ * h_);
  }

  /// How far a force of one carries the grains of a contact in a step, as bodies that only translate.
  double mobility(const Packing& packing, const SurfaceContact<Dim>& contact) const {
    double sum = 1 / packing.grains[contact.candidate].mass.sum();
    if (!contact.is_wall()) sum += 1 / packing.grains[contact.antagonist].mass.sum();
    return theta * h_ * h_ * sum;
  }

  /// Imbalance of one grain without contact forces.
  Nodal imbalance(const Packing& packing, Index g) const {
    const auto& grain = packing.grains[g];
    const Nodal dv = ((x[g] - grain.position) / h_ - grain.velocity) / theta;
    Nodal sum = dv * (grain.mass / h_).asDiagonal() + theta * force[g];
    if (theta < 1) sum += (1 - theta) * old_force_[g];
    return sum;
  }

 private:
  /// Whether do_grain(g) held for all.
  template <class DoGrain>
  bool for_each_grain(const Packing& packing, const DoGrain& do_grain) const {
    Array<char> good(packing.grains.size(), 1);
    parallel_for(threads, good.size(), [&](Index g) { good[g] = do_grain(g); });
    return std::all_of(good.begin(), good.end(), [](char ok) { return ok != 0; });
  }

  /// A force without its pull, its tangential part cut to the friction bound.
  static Vector<Dim> within_cone(const Vector<Dim>& force, const Vector<Dim>& normal, double friction) {
    const double pressing = normal.dot(force);
    if (!(pressing > 0)) return Vector<Dim>::Zero();
    const Vector<Dim> tangential = force - pressing * normal;
    const double length = tangential.norm(), bound = friction * pressing;
    return pressing * normal + (length <= bound ? 1.0 : bound / length) * tangential;
  }

  /// theta K + M / (theta h^2) from K.
  void add_inertia(const Packing& packing, Index g, BlockMatrix<Dim>& k) const {
    const auto& pattern = packing.model->pattern;
    if (theta != 1)
      for (auto& block : k.block) block *= theta;
    const double factor = 1 / (theta * h_ * h_);
    for (Index i = 0; i < pattern.n_rows(); ++i)
      k.block[pattern.position(i, i)].diagonal().array() += factor * packing.grains[g].mass[i];
  }

  /// Residual of the balance of momentum (eq. 6).
  template <class Contacts>
  void balance(const Packing& packing, const Contacts& contacts) {
    const double size = gather(packing, contacts, pair_force, wall_force);
    double error = 0, inertia = 0;
    for (Index g = 0; g < x.size(); ++g) {
      inertia += x[g].colwise().squaredNorm().dot(packing.grains[g].mass.cwiseAbs2());
      residual[g] = imbalance(packing, g) - contact_nodal_[g];
      error += residual[g].squaredNorm();
    }
    residual_norm = std::sqrt(error);
    round_off = std::numeric_limits<double>::epsilon() * std::sqrt(inertia) / (theta * h_ * h_);
    force_scale = std::max(std::sqrt(size), least_force);
  }

  /// Nodal contact forces of these reactions; their squared norm.
  template <class Contacts>
  double gather(const Packing& packing, const Contacts& contacts, const Array<ContactVector<N>>& of_pairs,
                const Array<ContactVector<1>>& of_walls) {
    for (auto& f : contact_nodal_) f.setZero(Dim, packing.n_nodes());
    contacts.scatter(of_pairs, of_walls, contact_nodal_);
    double sum = 0;
    for (const auto& f : contact_nodal_) sum += f.squaredNorm();
    return sum;
  }

  double h_ = 0;
  Array<Nodal> old_force_, contact_nodal_;
  Array<double> bound_;
};

}  // namespace jampack
