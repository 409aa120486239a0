// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <jampack/analysis/audit_compliance.hpp>
#include <jampack/analysis/audit_network.hpp>
#include <jampack/analysis/audit_penetration.hpp>
#include <jampack/geometry/frame.hpp>
#include <jampack/law/friction_cone.hpp>
#include <map>
#include <memory>
#include <optional>
#include <tuple>

namespace jampack {

/// Recomputes by brute force what must be true of a stored state, sharing no code with detection/, solver/
/// and stepping/. See audit() below.
template <class Element, class Material, int Dim>
class Audit {
 public:
  using Nodal = typename StoredGrain<Dim>::Nodal;

  Audit(const StoredState<Dim>& state, Threads threads)
      : state_(state), threads_(threads), boundary_(make_boundary(state.mesh)) {
    require(!state.grains.empty(), "audit: there is no grain");
    material_.young = state.young;
    material_.poisson = state.poisson;
    material_.density = state.density;
    for (const auto& grain : state.grains) mean_diameter_ += grain.diameter / double(state.grains.size());
    within_ = 0.1 * mean_diameter_;
    h_ = state.progress.last_duration;
  }

  AuditReport run() {
    prepare_grains();
    project_contacts();
    balance();
    contact_conditions();
    audit_network(state_, mean_diameter_, points_, report_);
    const auto penetration =
        audit_penetration(surfaces_, state_.room, within_, 1e-3 * mean_diameter_, threads_);
    report_.max_penetration_over_d = penetration.depth / mean_diameter_;
    report_.overlap_over_solid = penetration.overlap / report_.solid_volume;
    report_.self_penetration_over_d = penetration.self_depth / mean_diameter_;
    return report_;
  }

 private:
  using Surface = AuditSurface<Dim>;
  using Sample = typename Boundary<Dim>::Sample;

  using Point = AuditContact<Dim>;

  void prepare_grains() {
    const Index n = state_.grains.size();
    cells_.resize(n);
    mass_.resize(n);
    force_.resize(n);
    report_.min_jacobian = std::numeric_limits<double>::infinity();
    Array<double> smallest(n), moved(n), volume(n);
    Array<std::optional<Surface>> surfaces(n);
    parallel_for(threads_, n, [&](Index g) {
      const auto& grain = state_.grains[g];
      const Index n_nodes = state_.mesh.nodes.size();
      cells_[g] = Element::cells(state_.mesh, grain.diameter, grain.rotation);
      mass_[g] = Eigen::VectorXd::Zero(n_nodes);
      smallest[g] = std::numeric_limits<double>::infinity();
      for (const auto& cell : cells_[g]) {
        typename Element::VolumeShares shares = Element::VolumeShares::Zero();
        Element::add_volume_shares(cell, shares);
        for (int i = 0; i < Element::n_nodes; ++i)
          mass_[g][cell.node[std::size_t(i)]] += state_.density * shares[i];
        smallest[g] = std::min(smallest[g], Element::min_jacobian(cell, gather(cell, grain.position)));
      }
      force_[g] = internal_force(g, grain.position);
      if (h_ > 0) {
        force_[g] *= state_.theta;
        if (state_.theta < 1) force_[g] += (1 - state_.theta) * internal_force(g, grain.position_before);
        moved[g] = (grain.position - grain.position_before -
                    h_ * (state_.theta * grain.velocity + (1 - state_.theta) * grain.velocity_before))
                       .colwise()
                       .norm()
                       .maxCoeff();
      }
      surfaces[g].emplace(state_.mesh, grain.position);
      volume[g] = surfaces[g]->volume();
    });
    for (Index g = 0; g < n; ++g) {
      surfaces_.push_back(std::move(*surfaces[g]));
      report_.min_jacobian = std::min(report_.min_jacobian, smallest[g]);
      report_.kinematic_error = std::max(report_.kinematic_error, moved[g] / mean_diameter_);
      report_.solid_volume += volume[g];
    }
    report_.room_volume = state_.room.volume();
    report_.packing_fraction = report_.solid_volume / report_.room_volume;
  }

  static typename Element::Nodal gather(const typename Element::Cell& cell, const Nodal& x) {
    typename Element::Nodal local;
    for (int i = 0; i < Element::n_nodes; ++i) local.col(i) = x.col(cell.node[std::size_t(i)]);
    return local;
  }

  /// NaN where a cell is inverted: then nothing is in balance.
  Nodal internal_force(Index g, const Nodal& x) const {
    Nodal sum = Nodal::Zero(Dim, x.cols());
    typename Element::Nodal f;
    for (const auto& cell : cells_[g]) {
      if (!Element::force(cell, material_, gather(cell, x), f))
        f.setConstant(std::numeric_limits<double>::quiet_NaN());
      for (int i = 0; i < Element::n_nodes; ++i) sum.col(cell.node[std::size_t(i)]) += f.col(i);
    }
    return sum;
  }

  static Vector<Dim> at_sample(const Sample& sample, const Nodal& x) {
    Vector<Dim> sum = Vector<Dim>::Zero();
    for (Index i = 0; i < sample.n; ++i) sum += sample.weight[i] * x.col(sample.node[std::size_t(i)]);
    return sum;
  }

  /// Every stored contact that carries force, and every sample that penetrates, at its projection now.
  void project_contacts() {
    using Key = std::tuple<Index, Index, Index>;
    std::multimap<Key, const StoredContact<Dim>*> known;  // several at a crease
    const auto take = [&](const auto& contacts) {
      for (const auto& c : contacts) {
        require(c.sample < boundary_.samples.size(), "audit: a contact lies where the mesh has no sample");
        known.emplace(Key{c.candidate, c.sample, c.antagonist}, &c);
      }
    };
    take(state_.pairs);
    take(state_.walls);
    const Index n = state_.grains.size();
    Array<Array<Point>> found(n);
    Array<Index> missed(n, 0);
    parallel_for(threads_, n, [&](Index a) {
      for (Index s = 0; s < boundary_.samples.size(); ++s) {
        const Sample& sample = boundary_.samples[s];
        const Vector<Dim> x = at_sample(sample, state_.grains[a].position);
        const auto sample_begin = known.lower_bound({a, s, std::numeric_limits<Index>::min()});
        const auto sample_end = known.lower_bound({a, s + 1, std::numeric_limits<Index>::min()});
        const auto visit = [&](Index antagonist, auto project, Index n_unknowns) {
          const auto is_of = [&](const auto& entry) { return std::get<2>(entry.first) == antagonist; };
          const auto begin = std::find_if(sample_begin, sample_end, is_of);
          const auto end = std::find_if_not(begin, sample_end, is_of);
          const bool carries =
              std::any_of(begin, end, [](const auto& entry) { return !entry.second->reaction.isZero(0); });
          if (!carries && antagonist >= 0 && !surfaces_[antagonist].may_reach(x, 0)) return;
          const typename Surface::Projection p = project();
          const Point point{
              a, antagonist, &sample, Vector<Dim>::Zero(), p, p, slack(a, s, antagonist), n_unknowns};
          if (begin == end && p.gap + point.slack < 0) {
            if (p.gap + point.slack < -1e-6 * mean_diameter_) ++missed[a];
            found[a].push_back(point);
          }
          for (auto entry = begin; entry != end; ++entry) add_stored(point, *entry->second, x, found[a]);
        };
        for (Index w = 0; w < state_.room.n_walls(); ++w)
          visit(
              -1 - w,
              [&] {
                typename Surface::Projection p;
                p.normal = state_.room.normal[w];
                p.gap = p.normal.dot(x - state_.room.centre) + state_.room.scale * state_.room.distance[w];
                return p;
              },
              1);
        for (Index b = 0; b < n; ++b)
          if (b != a)
            visit(
                b, [&] { return surfaces_[b].project(x, within_); }, state_.n_pair_unknowns);
      }
    });
    for (Index a = 0; a < n; ++a) {
      points_.insert(points_.end(), found[a].begin(), found[a].end());
      report_.n_missed += missed[a];
    }
  }

  /// Adds a stored contact of the sample at x, if it carries a force or is entered; `point` says where the
  /// sample is now.
  void add_stored(Point point, const StoredContact<Dim>& stored, const Vector<Dim>& x,
                  Array<Point>& found) const {
    const bool carries = !stored.reaction.isZero(0);
    if (point.antagonist >= 0) {
      point.frame = step_frame(stored, x);
      // A force of one unknown acts along the normal of its face, as that is now.
      const bool is_there = point.at.face == stored.face;
      if (point.n_unknowns == 1)
        point.at.normal =
            surfaces_[point.antagonist].own_normal(stored.face, is_there ? point.at.xi : stored.xi);
    }
    if (!carries && !(point.frame.gap + point.slack < 0)) return;
    if (carries)
      point.force =
          point.n_unknowns == 1 ? Vector<Dim>(stored.reaction[0] * point.at.normal) : stored.reaction;
    found.push_back(point);
  }

  /// How far a sample may enter: nodes of the smaller grain (the first of two of one size) not at all, all
  /// others as far as the mesh's boundary says.
  double slack(Index grain, Index sample, Index antagonist) const {
    const double d = state_.grains[grain].diameter;
    const bool leads = antagonist < 0 || d < state_.grains[antagonist].diameter ||
                       (d == state_.grains[antagonist].diameter && grain < antagonist);
    return boundary_.slack(sample, leads) * d;
  }

  /// The frame a stored contact was solved in, with the gap of x in it.
  typename Surface::Projection step_frame(const StoredContact<Dim>& stored, const Vector<Dim>& x) const {
    typename Surface::Projection frame;
    frame.face = stored.face;
    frame.xi = stored.xi;
    frame.normal = stored.normal;
    frame.gap = frame.normal.dot(x - surfaces_[stored.antagonist].position(stored.face, stored.xi));
    return frame;
  }

  /// Adds the nodal forces of a contact point, its antagonist met at `at`.
  template <class Add>
  void spread(const Point& point, const typename Surface::Projection& at, Add add) const {
    for (Index i = 0; i < point.sample->n; ++i)
      add(point.candidate, point.sample->node[std::size_t(i)], point.sample->weight[i]);
    if (point.antagonist < 0 || at.face < 0) return;
    const auto& face = state_.mesh.faces[at.face];
    const auto weight = surfaces_[point.antagonist].weights(at.face, at.xi);
    for (Index i = 0; i < face.n_nodes; ++i) add(point.antagonist, face.node[std::size_t(i)], -weight[i]);
  }

  void balance() {
    report_.equilibrium_residual = imbalance(&Point::at);
    report_.step_residual = imbalance(&Point::frame);
  }

  /// Relative residual of the balance of momentum with contacts met where `place` says.
  double imbalance(typename Surface::Projection Point::*place) const {
    Array<Nodal> contact(state_.grains.size());
    for (auto& f : contact) f = Nodal::Zero(Dim, state_.mesh.nodes.size());
    for (const Point& point : points_) {
      if (point.force.isZero(0)) continue;
      const auto& met = point.*place;
      const Vector<Dim> force =
          point.n_unknowns == 1 ? Vector<Dim>(point.force.dot(point.at.normal) * met.normal) : point.force;
      spread(point, met, [&](Index g, Index node, double w) { contact[g].col(node) += w * force; });
    }
    double error = 0, size = 0;
    for (Index g = 0; g < state_.grains.size(); ++g) {
      Nodal residual = force_[g] - contact[g];
      if (h_ > 0)
        residual +=
            (state_.grains[g].velocity - state_.grains[g].velocity_before) * (mass_[g] / h_).asDiagonal();
      error += residual.squaredNorm();
      size += contact[g].squaredNorm();
    }
    // Without a contact force there is no scale but the grains' own stiffness.
    const double scale = size > 0 ? std::sqrt(size) : state_.young * std::pow(mean_diameter_, Dim - 1) * 1e-6;
    return std::sqrt(error) / scale;
  }

  /// Natural map of the contact conditions in the frames of the step; displacements stand for velocities and
  /// forces for impulses, which scales both by h.
  void contact_conditions() {
    const Index n = state_.grains.size();
    // Before the first step there is no duration: an elastic wave's through a grain.
    const double h = h_ > 0 ? h_ : mean_diameter_ * std::sqrt(state_.density / state_.young);
    Array<char> touched(n, 0);
    for (const Point& point : points_) {
      touched[point.candidate] = 1;
      if (point.antagonist >= 0) touched[point.antagonist] = 1;
    }
    Array<std::unique_ptr<Compliance>> compliance(n);
    parallel_for(threads_, n, [&](Index g) {
      if (touched[g])
        compliance[g] = std::make_unique<Compliance>(state_.mesh, cells_[g], material_,
                                                     state_.grains[g].position, mass_[g], state_.theta, h);
    });
    double error = 0, size = 0;
    for (const Point& point : points_) {
      double trace = 0;
      const auto add = [&](Index g, const Index* node, const double* weight, Index n_nodes) {
        for (Index i = 0; i < n_nodes; ++i)
          for (Index j = 0; j <= i; ++j) {
            const double w = (i == j ? 1 : 2) * weight[i] * weight[j];
            if (w == 0) continue;
            for (int a = 0; a < Dim; ++a) {
              if (point.n_unknowns > 1) {
                trace += w * compliance[g]->entry(node[i], a, node[j], a);
              } else {
                for (int b = 0; b < Dim; ++b)
                  trace += w * point.frame.normal[a] * point.frame.normal[b] *
                           compliance[g]->entry(node[i], a, node[j], b);
              }
            }
          }
      };
      add(point.candidate, point.sample->node.data(), point.sample->weight.data(), point.sample->n);
      if (point.antagonist >= 0 && point.frame.face >= 0) {
        const auto& face = state_.mesh.faces[point.frame.face];
        const auto weight = surfaces_[point.antagonist].weights(point.frame.face, point.frame.xi);
        add(point.antagonist, face.node.data(), weight.data(), face.n_nodes);
      }
      size += point.force.squaredNorm();
      error += natural_map(point, double(point.n_unknowns) / trace);
    }
    report_.scaled_residual = size > 0 ? std::sqrt(error / size) : std::sqrt(error);
  }

  /// Square of r - P_K(r - rho (s + friction |s_T| n)), s the displacement of the contact in the step: the
  /// gap at its end along the normal, the slip across.
  double natural_map(const Point& point, double rho) const {
    const auto& at = point.frame;
    if (point.n_unknowns == 1) {
      const ContactVector<1> r(point.force.dot(point.at.normal)), z(r[0] - rho * (at.gap + point.slack));
      return (r - project_on_friction_cone<1>(z, 0)).squaredNorm();
    }
    Vector<Dim> relative = Vector<Dim>::Zero();
    spread(point, at, [&](Index g, Index node, double w) {
      relative += w * (state_.grains[g].position.col(node) - state_.grains[g].position_before.col(node));
    });
    const auto frame = contact_frame<Dim>(at.normal);
    const ContactVector<Dim> r = frame * point.force;
    ContactVector<Dim> s = frame * relative;
    s[0] = at.gap + point.slack;
    const ContactVector<Dim> z = r - rho * de_saxce_velocity<Dim>(s, state_.friction);
    return (r - project_on_friction_cone<Dim>(z, state_.friction)).squaredNorm();
  }

  using Compliance = AuditCompliance<Element, Material, Dim>;

  const StoredState<Dim>& state_;
  Threads threads_;
  Boundary<Dim> boundary_;
  Material material_;
  double mean_diameter_ = 0, within_ = 0, h_ = 0;
  Array<Array<typename Element::Cell>> cells_;
  Array<Eigen::VectorXd> mass_;
  Array<Nodal> force_;  ///< internal, weighted by theta over the step
  Array<Surface> surfaces_;
  Array<Point> points_;
  AuditReport report_;
};

/// The audit of a stored state. `Element` and `Material` must be those the state names; throws InvalidInput
/// otherwise and where the state cannot be audited at all.
///
/// scaled_residual is taken relative to |r| alone, not to max(|r|, |rho q|): a stricter measure.
template <class Element, class Material, int Dim>
AuditReport audit(const StoredState<Dim>& state, Threads threads = {}) {
  require(state.element == Element::name, "audit: the state has element " + state.element);
  return Audit<Element, Material, Dim>(state, threads).run();
}

}  // namespace jampack
