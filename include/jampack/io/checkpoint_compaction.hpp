// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/io/checkpoint.hpp>
#include <jampack/material/linear_elastic.hpp>
#include <jampack/material/neo_hookean.hpp>
#include <jampack/stepping/compaction.hpp>

namespace jampack {

/// How a material is called in a stored state.
template <class Material>
inline constexpr std::string_view stored_material_name = "";
template <>
inline constexpr std::string_view stored_material_name<NeoHookean> = "neo_hookean";
template <>
inline constexpr std::string_view stored_material_name<NeoHookeanQuadratic> = "neo_hookean_quadratic";
template <>
inline constexpr std::string_view stored_material_name<LinearElastic> = "linear_elastic";

/// The state of a compaction after its last accepted step. `parameters` are the program's own, kept as they
/// are.
template <class Packing, ContactLaw Law, class Solver>
StoredState<Packing::dimension> stored_state(const Compaction<Packing, Law, Solver>& compaction,
                                             std::map<std::string, std::string> parameters = {}) {
  constexpr int Dim = Packing::dimension, N = n_contact_unknowns<Law, Dim>;
  static_assert(!stored_material_name<typename Packing::Material>.empty(), "give the material a stored name");
  const auto& packing = compaction.packing;
  const auto& material = packing.model->material;
  StoredState<Dim> state;
  state.element = Packing::Element::name;
  state.material = stored_material_name<typename Packing::Material>;
  state.young = material.young;
  state.poisson = material.poisson;
  state.density = material.density;
  state.n_pair_unknowns = N;
  state.friction = compaction.step.law.friction;
  state.theta = compaction.step.options.theta;
  state.room = packing.room;
  state.mesh = packing.model->mesh;
  const bool has_moved = !compaction.position_before.empty();
  for (Index g = 0; g < packing.grains.size(); ++g) {
    const auto& grain = packing.grains[g];
    state.grains.push_back({grain.diameter, grain.rotation, grain.position, grain.velocity,
                            has_moved ? compaction.position_before[g] : grain.position,
                            has_moved ? compaction.velocity_before[g] : grain.velocity});
  }
  const auto keep = [](const auto& set, Array<StoredContact<Dim>>& stored) {
    for (Index c = 0; c < set.size(); ++c) {
      const auto& contact = set.contact[c];
      stored.push_back({contact.candidate, contact.sample, contact.antagonist, contact.face, contact.xi,
                        contact.normal, contact.slack});
      stored.back().reaction.head(set.reaction[c].size()) = set.reaction[c];
    }
  };
  keep(compaction.step.contacts.pairs, state.pairs);
  keep(compaction.step.contacts.walls, state.walls);
  state.progress = {compaction.n_steps,
                    compaction.n_iterations,
                    compaction.n_failed,
                    compaction.strain,
                    compaction.last_duration,
                    compaction.last_pressure,
                    compaction.gain,
                    compaction.report.equilibrium_residual,
                    compaction.report.scaled_residual};
  state.parameters = std::move(parameters);
  return state;
}

/// The compaction that stored_state() was taken of, to be continued as if it had never stopped: its further
/// steps are the same bit for bit where law and options are. Throws InvalidInput where the state is of
/// another element, material or law, or its parts do not fit together.
template <class Packing, ContactLaw Law, class Solver = ProximalNewton>
Compaction<Packing, Law, Solver> restored_compaction(const StoredState<Packing::dimension>& state, Law law,
                                                     CompactionOptions options,
                                                     SoftStepOptions step_options) {
  constexpr int Dim = Packing::dimension, N = n_contact_unknowns<Law, Dim>;
  require(state.element == Packing::Element::name,
          "the checkpoint has element " + state.element + ", not " + std::string(Packing::Element::name));
  require(state.material == stored_material_name<typename Packing::Material>,
          "the checkpoint has material " + state.material + ", not " +
              std::string(stored_material_name<typename Packing::Material>));
  require(state.n_pair_unknowns == N && state.friction == law.friction,
          "the checkpoint has friction " + std::to_string(state.friction) + ", not " +
              std::to_string(double(law.friction)));
  require(state.theta == step_options.theta, "the checkpoint has theta " + std::to_string(state.theta) +
                                                 ", not " + std::to_string(step_options.theta));
  typename Packing::Material material;
  material.young = state.young;
  material.poisson = state.poisson;
  material.density = state.density;
  material.validate();
  Packing packing(state.mesh, material, state.room);
  for (const auto& stored : state.grains) {
    packing.add(stored.diameter, Vector<Dim>::Zero(), stored.rotation);
    packing.grains.back().position = stored.position;
    packing.grains.back().velocity = stored.velocity;
  }
  Compaction<Packing, Law, Solver> compaction(std::move(packing), law, options, step_options);
  if (state.progress.n_steps > 0)
    for (const auto& stored : state.grains) {
      compaction.position_before.push_back(stored.position_before);
      compaction.velocity_before.push_back(stored.velocity_before);
    }

  Array<GrainSurface<Dim>> surfaces(state.grains.size());
  const auto& boundary = compaction.packing.model->boundary;
  for (Index g = 0; g < surfaces.size(); ++g)
    surfaces[g].update(boundary, compaction.packing.grains[g].position,
                       compaction.packing.grains[g].diameter);
  const auto take = [&](const Array<StoredContact<Dim>>& stored, auto& set) {
    for (const auto& from : stored) {
      require(from.sample < boundary.samples.size(), "the checkpoint has a contact where its mesh has none");
      auto& contact = set.contact.emplace_back();
      contact.candidate = from.candidate;
      contact.sample = from.sample;
      contact.antagonist = from.antagonist;
      contact.slack = from.slack;
      contact.own = node_weights(boundary.samples[from.sample]);
      const Vector<Dim> x = weighted_point(contact.own, compaction.packing.grains[from.candidate].position);
      if (from.is_wall()) {
        contact.normal = state.room.normal[from.wall()];
        contact.gap = state.room.gap(from.wall(), x) + contact.slack;
      } else {
        // The frame as it was: a projection started anew may end elsewhere.
        hold(contact, surfaces[from.antagonist], {from.face, from.xi, from.normal}, x);
      }
      auto& reaction = set.reaction.emplace_back();
      reaction = from.reaction.head(reaction.size());
    }
  };
  take(state.pairs, compaction.step.contacts.pairs);
  take(state.walls, compaction.step.contacts.walls);
  const auto& at = state.progress;
  compaction.n_steps = Index(at.n_steps);
  compaction.n_iterations = Index(at.n_iterations);
  compaction.n_failed = Index(at.n_failed);
  compaction.strain = at.strain;
  compaction.last_duration = at.last_duration;
  compaction.last_pressure = at.last_pressure;
  compaction.gain = at.gain;
  compaction.report.converged = at.n_steps > 0;
  compaction.report.equilibrium_residual = at.equilibrium_residual;
  compaction.report.scaled_residual = at.scaled_residual;
  return compaction;
}

}  // namespace jampack
