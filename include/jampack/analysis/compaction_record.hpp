// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/analysis/contact_strain.hpp>
#include <jampack/analysis/coordination.hpp>
#include <jampack/analysis/elastic_moduli.hpp>
#include <jampack/analysis/grain_shape.hpp>
#include <jampack/analysis/record.hpp>
#include <jampack/analysis/stress_field.hpp>
#include <jampack/body/surface_measure.hpp>
#include <jampack/core/error.hpp>

namespace jampack {

/// What the analyses of a compaction look at, computed once a record: a run (stepping/compaction.hpp), its
/// contact network, and what the surfaces of its grains enclose.
template <class Run>
struct CompactionState {
  static constexpr int Dim = Run::Dim;

  const Run& run;
  ContactNetwork<Dim> network;
  Coordination count;
  Array<double> volumes, surfaces;  ///< of the grains, current

  explicit CompactionState(const Run& of_run) : run(of_run), network(of_run.network()) {
    bool frictional = false;
    if constexpr (requires { run.step.law.friction; }) frictional = run.step.law.friction > 0;
    count = coordination(network, contacts_to_hold<Dim>(frictional));
    for (const auto& grain : run.packing.grains) {
      const auto measure = measure_surface<Dim>(run.packing.model->boundary, grain.position);
      volumes.push_back(measure.volume);
      surfaces.push_back(measure.area);
    }
  }

  double packing_fraction() const {
    double sum = 0;
    for (const double volume : volumes) sum += volume;
    return sum / run.packing.room.volume();
  }
};

/// phi: the grains' volumes within their curved surfaces over the room's.
struct PackingFraction {
  static constexpr std::array<std::string_view, 1> columns{"phi"};
  std::array<double, 1> operator()(const auto& state) const { return {state.packing_fraction()}; }
};

/// P / E* with E* = E / [2 (1 - nu^2)], P the granular pressure.
struct ReducedPressure {
  static constexpr std::array<std::string_view, 1> columns{"P_over_Estar"};
  std::array<double, 1> operator()(const auto& state) const {
    const auto& material = state.run.packing.model->material;
    return {granular_pressure(state.network) / reduced_modulus(material.young, material.poisson)};
  }
};

/// Z = 2 N_c / N_p over contacts between grains, of all grains and without rattlers.
struct CoordinationNumbers {
  static constexpr std::array<std::string_view, 2> columns{"Z", "Z_no_rattlers"};
  std::array<double, 2> operator()(const auto& state) const {
    return {state.count.all.coordination(), state.count.held.coordination()};
  }
};

/// Contacts that count: all, and those of them at walls.
struct ContactNumbers {
  static constexpr std::array<std::string_view, 2> columns{"contacts", "wall_contacts"};
  std::array<double, 2> operator()(const auto& state) const {
    const auto& all = state.count.all;
    return {double(all.n_grain_contacts + all.n_wall_contacts), double(all.n_wall_contacts)};
  }
};

/// <delta> / <d> over contacts between grains.
struct MeanContactStrain {
  static constexpr std::array<std::string_view, 1> columns{"contact_strain"};
  std::array<double, 1> operator()(const auto& state) const {
    return {contact_strain(state.network, state.count.threshold)};
  }
};

/// Mean sphericity (circularity in 2D) of the undeformed grains less that of the grains as they are.
struct SphericityLoss {
  static constexpr std::array<std::string_view, 1> columns{"sphericity_loss"};
  std::array<double, 1> operator()(const auto& state) const {
    constexpr int Dim = std::remove_cvref_t<decltype(state)>::Dim;
    const auto& model = *state.run.packing.model;
    Eigen::Matrix<double, Dim, Eigen::Dynamic> reference(Dim, model.mesh.nodes.size());
    for (Index i = 0; i < model.mesh.nodes.size(); ++i) reference.col(i) = model.mesh.nodes[i];
    const auto undeformed = measure_surface<Dim>(model.boundary, reference);
    return {roundness<Dim>(undeformed.volume, undeformed.area) -
            mean_roundness<Dim>(state.volumes, state.surfaces)};
  }
};

/// Standard deviation over mean of the von Mises stress in the grains.
struct VonMisesSpread {
  static constexpr std::array<std::string_view, 1> columns{"von_mises_sd"};
  std::array<double, 1> operator()(const auto& state) const {
    return {normalised_standard_deviation(von_mises_field(state.run.packing))};
  }
};

/// What the run took so far: Newton iterations (each one sweep over all contacts) and accepted steps.
struct Effort {
  static constexpr std::array<std::string_view, 2> columns{"sweeps", "steps"};
  std::array<double, 2> operator()(const auto& state) const {
    return {double(state.run.n_iterations), double(state.run.n_steps)};
  }
};

/// The analyses of the paper that compaction programs record.
using CompactionAnalyses = Analyses<PackingFraction, ReducedPressure, CoordinationNumbers, MeanContactStrain,
                                    SphericityLoss, VonMisesSpread, ContactNumbers, Effort>;

}  // namespace jampack
