// SPDX-License-Identifier: MIT
#pragma once

// What compact_spheres and compact_disks share: random packing -> jammed -> meshed -> pressed to sigma0 ->
// compacted, with a record, a checkpoint and a VTU file every so much of phi.
#include <jampack/analysis/audit.hpp>
#include <jampack/analysis/compaction_fits.hpp>
#include <jampack/analysis/compaction_record.hpp>
#include <jampack/analysis/micromechanical_law.hpp>
#include <jampack/element/linear_simplex.hpp>
#include <jampack/element/macro_simplex.hpp>
#include <jampack/element/quadratic_simplex.hpp>
#include <jampack/io/checkpoint_compaction.hpp>
#include <jampack/io/command_line.hpp>
#include <jampack/io/csv_table.hpp>
#include <jampack/io/csv_writer.hpp>
#include <jampack/io/curve_picture.hpp>
#include <jampack/io/failed_step.hpp>
#include <jampack/io/progress.hpp>
#include <jampack/io/pvd.hpp>
#include <jampack/io/run_program.hpp>
#include <jampack/io/soft_packing_picture.hpp>
#include <jampack/io/soft_packing_vtu.hpp>
#include <jampack/io/surface_picture.hpp>
#include <jampack/law/signorini_coulomb.hpp>
#include <jampack/material/neo_hookean.hpp>
#include <jampack/packing/handover.hpp>
#include <jampack/packing/random_packing.hpp>
#include <jampack/stepping/jam.hpp>
#include <jampack/stepping/press_to.hpp>
#include <optional>

namespace jampack {

inline constexpr double preparation_stress = 1e-5;  ///< sigma0 / E
inline constexpr double settled_above = 10;  ///< P / sigma0 above which records are of settled packings

/// The options of a compaction program.
struct CompactionParameters {
  Index grains = 100;
  double friction = 0.3;
  double poisson = 0.495;
  Index cells = 808;
  double until = 0.96;
  std::string resume;
  double every = 0.005;
  std::string element = "macro";
  std::string out = ".";
  Index threads = 1;
  Index seed = 1;
};

/// The laws P(phi) with the constants a curve itself gives, beside the fits they come from.
template <int Dim>
struct CurveLaws {
  MicromechanicalLaw<Dim> micromechanical;
  HeckelSecondiLaw heckel_secondi;
};

/// phi0 and Z0 are the first record's. Throws InvalidInput or NotConverged where the curve is too short.
template <int Dim>
CurveLaws<Dim> laws_of(const CsvTable& curve) {
  const auto& phi = curve.column("phi");
  const auto& pressure = curve.column("P_over_Estar");
  const auto& z = curve.column("Z");
  require(phi.size() >= 5, "fewer than five records");
  const double phi0 = phi[0], z0 = z[0];
  const auto heckel = fit_heckel_secondi(phi, pressure, phi0).law();
  const double psi = fit_coordination(phi, z, phi0, z0).psi.slope.value;
  const double gamma = fit_contact_strain(phi, curve.column("contact_strain"), phi0).gamma.value;
  CurveLaws<Dim> laws{{.phi0 = phi0, .phi_max = heckel.phi_max, .z0 = z0, .psi = psi, .gamma = gamma},
                      heckel};
  if constexpr (Dim == 2) {
    // The stiffness of a line contact is measured: P over the small-strain law with k = 1, at small strain.
    Array<double> unit, measured;
    for (Index i = 1; i < phi.size(); ++i)
      if (std::log(phi[i] / phi0) <= 0.1) {
        unit.push_back(laws.micromechanical.small_strain()(phi[i]));
        measured.push_back(pressure[i]);
      }
    laws.micromechanical.contact_stiffness = slope_fit(unit, measured).slope.value;
  }
  return laws;
}

/// One run of a compaction program with this element.
template <int Dim, template <int> class Element>
class CompactionProgram {
  using Law = SignoriniCoulomb;
  using Packing = SoftPacking<Dim, Element<Dim>, NeoHookean>;
  using Run = Compaction<Packing, Law>;

 public:
  CompactionProgram(const CompactionParameters& parameters, Mesh<Dim> mesh, Json summary)
      : parameters_(parameters),
        mesh_(std::move(mesh)),
        folder_(parameters.out),
        summary_(std::move(summary)) {}

  /// From a random packing.
  int start() {
    const auto jammed = jammed_packing();
    Run run(meshed_grains<Element>(jammed.packing, mesh_, material()), law(), {}, step_options());
    std::filesystem::create_directories(folder_ / "packing");
    csv_.emplace(folder_ / "curve.csv", columns());
    pvd_.emplace(folder_ / "packing.pvd");
    progress_.phase("pressing to sigma0", preparation_stress);
    try {
      press_to(run, {.stress = preparation_stress}, [&](const Run& now) {
        progress_.show(now.pressure(), {{"phi", now.packing_fraction()},
                                        {"P/E", now.pressure()},
                                        {"sweeps", double(now.report.iterations)}});
      });
    } catch (const NotConverged& error) {
      throw NotConverged(error.what() + save_failed_step(run));
    }
    record(run);
    return compact(run);
  }

  /// From a checkpoint of this program; its parameters are already taken over.
  int resume(const StoredState<Dim>& state) {
    const auto kept = [&](const char* name) {
      const auto entry = state.parameters.find(name);
      require(entry != state.parameters.end(), parameters_.resume + ": no checkpoint of this program");
      return to_number<double>(entry->second).value_or(0);
    };
    n_records_ = static_cast<Index>(kept("records"));
    seconds_before_ = kept("seconds");
    phi_ = kept("phi");
    pressure_ = kept("P_over_Estar");
    coordination_ = kept("Z");
    const auto source = std::filesystem::path(parameters_.resume).parent_path();
    if (!std::filesystem::exists(folder_ / "curve.csv"))
      for (const char* name : {"curve.csv", "packing.pvd", "packing"}) {
        require(std::filesystem::exists(source / name),
                parameters_.resume + ": " + name + " of its run is missing beside it; move both together");
        std::filesystem::copy(source / name, folder_ / name, std::filesystem::copy_options::recursive);
      }
    csv_.emplace(CsvWriter::resume(folder_ / "curve.csv", columns(), n_records_));
    pvd_.emplace(PvdSeries::resume(folder_ / "packing.pvd", 2 * n_records_));
    auto run = restored_compaction<Packing>(state, law(), CompactionOptions{}, step_options());
    return compact(run);
  }

 private:
  NeoHookean material() const { return {.young = 1, .poisson = parameters_.poisson}; }
  Law law() const { return {.friction = parameters_.friction}; }
  SoftStepOptions step_options() const {
    SoftStepOptions options;
    options.threads.count = static_cast<int>(parameters_.threads);
    return options;
  }

  JammedPacking<Dim> jammed_packing() {
    const auto loose = random_packing<Dim>(
        {.n_grains = parameters_.grains, .seed = static_cast<std::uint64_t>(parameters_.seed)});
    progress_.phase("jamming", 1e-6);
    auto jammed = jam(loose, law(), {.stress = preparation_stress}, GaussSeidel{},
                      [&](const JamReport& report, double phi) {
                        progress_.show(0, {{"phi", phi},
                                           {"kinetic energy", report.kinetic_energy},
                                           {"sweeps", double(report.sweeps)},
                                           {"residual", report.scaled_residual}});
                      });
    summary_["jammed"]["phi"] = jammed.packing_fraction;
    summary_["jammed"]["Z"] = jammed.coordination.all.coordination();
    summary_["jammed"]["Z_no_rattlers"] = jammed.coordination.held.coordination();
    summary_["jammed"]["seconds"] = jammed.report.seconds;
    return jammed;
  }

  static Array<std::string> columns() {
    Array<std::string> names(CompactionAnalyses::columns.begin(), CompactionAnalyses::columns.end());
    for (const char* name : {"scaled_residual", "equilibrium_residual", "grain_imbalance",
                             "max_penetration_over_d", "overlap_over_solid", "min_J", "seconds"})
      names.push_back(name);
    return names;
  }

  void record(const Run& run) {
    const CompactionState<Run> state(run);
    const auto values = CompactionAnalyses{}(state);
    Array<double> row(values.begin(), values.end());
    const auto stored = stored_state(run);
    const AuditReport audited =
        audit<Element<Dim>, NeoHookean>(stored, Threads{static_cast<int>(parameters_.threads)});
    for (const double value :
         {audited.scaled_residual, audited.equilibrium_residual, audited.grain_imbalance,
          audited.max_penetration_over_d, audited.overlap_over_solid, audited.min_jacobian, seconds()})
      row.push_back(value);
    csv_->write(row);
    phi_ = values[CompactionAnalyses::column("phi")];
    pressure_ = values[CompactionAnalyses::column("P_over_Estar")];
    coordination_ = values[CompactionAnalyses::column("Z")];

    char number[16];
    std::snprintf(number, sizeof number, "%05td", n_records_++);
    const auto grains = folder_ / "packing" / ("grains_" + std::string(number) + ".vtu");
    const auto contacts = folder_ / "packing" / ("contacts_" + std::string(number) + ".vtu");
    write_vtu(grains, grains_vtu(run.packing));
    write_vtu(contacts, contacts_vtu(run.packing, state.network));
    pvd_->add(phi_, grains, 0);
    pvd_->add(phi_, contacts, 1);
    write_checkpoint(folder_ / "checkpoint.jpk", stored_state(run, stored_parameters()));
  }

  std::map<std::string, std::string> stored_parameters() const {
    const auto& p = parameters_;
    return {{"grains", to_text(p.grains)},
            {"friction", to_text(p.friction)},
            {"poisson", to_text(p.poisson)},
            {"cells", to_text(p.cells)},
            {"element", p.element},
            {"seed", to_text(p.seed)},
            {"every", to_text(p.every)},
            {"records", to_text(n_records_)},
            {"seconds", to_text(seconds())},
            {"phi", to_text(phi_)},
            {"P_over_Estar", to_text(pressure_)},
            {"Z", to_text(coordination_)}};
  }
  double seconds() const { return seconds_before_ + clock_.seconds(); }

  int compact(Run& run) {
    progress_.phase("compaction", parameters_.until);
    bool converged = true;
    std::string failure;
    try {
      while (phi_ < parameters_.until) {
        // A little beyond the end: what a step misses would take one that is next to nothing.
        const double beyond = 0.05 * parameters_.every;
        const double target = std::min(phi_ + parameters_.every, parameters_.until + beyond);
        run.advance_to(target, target < parameters_.until ? 2 * beyond : beyond,
                       [&](const Run& now) { show(now, now.packing_fraction()); });
        // Where it does not settle the record's grain_imbalance says so.
        if (run.pressure() > settled_above * preparation_stress)
          run.settle([&](const Run& settling) { show(settling, settling.packing_fraction()); });
        record(run);
      }
    } catch (const NotConverged& error) {
      converged = false;
      failure = error.what();
    }
    progress_.finish();
    finish(run, converged, failure);
    if (!converged)
      throw NotConverged(failure + "; the last record is kept in " + (folder_ / "checkpoint.jpk").string() +
                         save_failed_step(run));
    return 0;
  }

  /// Leaves the contact problem of the step that was given up; says where, for the end of the error line.
  std::string save_failed_step(Run& run) const {
    const auto path = folder_ / "failed_step.txt";
    return write_failed_step(path, run.step)
               ? "; the contact problem of the failed step is in " + path.string()
               : "";
  }

  void show(const Run& run, double phi) {
    progress_.show(phi, {{"phi", phi},
                         {"P/E*", run.pressure() / modulus()},
                         {"Z", coordination_},
                         {"sweeps", double(run.report.sweeps)},
                         {"residual", run.report.scaled_residual}});
  }

  double modulus() const { return reduced_modulus(1, parameters_.poisson); }

  void finish(const Run& run, bool converged, const std::string& failure) {
    Json& result = summary_["results"];
    result["converged"] = Json(converged);
    if (!converged) result["failure"] = failure;
    result["phi"] = phi_;
    result["P_over_Estar"] = pressure_;
    result["Z"] = coordination_;
    result["records"] = n_records_;
    result["cells_a_grain"] = run.packing.model->mesh.cells.size();
    result["unknowns"] = run.packing.n_dofs();
    result["steps"] = run.n_steps;
    result["iterations"] = run.n_iterations;
    result["failed_steps"] = run.n_failed;
    result["seconds"] = seconds();
    draw_pictures(run);
    write_file(folder_ / "summary.json", summary_.text());
  }

  void draw_pictures(const Run& run) {
    CurvePicture picture;
    picture.x_label = "packing fraction";
    picture.y_label = "P / E*, E* = E / [2 (1 - nu^2)]";
    picture.curves.push_back({"curve.csv", "phi", "P_over_Estar", "measured", true});
    const CsvTable curve = read_csv(folder_ / "curve.csv");
    Json& fitted = summary_["laws"];
    try {
      const auto laws = laws_of<Dim>(curve);
      const auto& micro = laws.micromechanical;
      fitted["phi0"] = micro.phi0;
      fitted["Z0"] = micro.z0;
      fitted["psi"] = micro.psi;
      fitted["Gamma"] = micro.gamma;
      if constexpr (Dim == 2) fitted["k"] = micro.contact_stiffness;
      fitted["phi_max"] = laws.heckel_secondi.phi_max;
      fitted["A"] = laws.heckel_secondi.amplitude;
      CsvWriter table(folder_ / "laws.csv", {"phi", "heckel_secondi", "micromechanical"});
      const Index n = 200;
      for (Index i = 0; i <= n; ++i) {
        const double phi = micro.phi0 + (phi_ - micro.phi0) * double(i) / double(n);
        table.write(Array<double>{phi, laws.heckel_secondi(phi), micro(phi)});
      }
      picture.curves.push_back({"laws.csv", "phi", "heckel_secondi", "Heckel-Secondi, fitted"});
      picture.curves.push_back({"laws.csv", "phi", "micromechanical", "micromechanical law"});
    } catch (const Error& error) {
      fitted["none"] = error.what();
    }
    draw(picture, folder_ / "curve.png");
    draw(picture_of(run.packing), "von Mises stress / E", folder_ / "packing.png");
  }

  CompactionParameters parameters_;
  Mesh<Dim> mesh_;
  std::filesystem::path folder_;
  Json summary_;
  Progress progress_;
  Stopwatch clock_;
  std::optional<CsvWriter> csv_;
  std::optional<PvdSeries> pvd_;
  Index n_records_ = 0;
  double seconds_before_ = 0;
  double phi_ = 0, pressure_ = 0, coordination_ = 0;  ///< of the last record
};

/// Takes what was asked for when a run began from its checkpoint. Throws InvalidInput where the command line
/// says otherwise.
inline void take_over(CommandLine& line, CompactionParameters& p,
                      const std::map<std::string, std::string>& stored) {
  const auto take = [&]<class T>(const char* name, T& value) {
    const auto entry = stored.find(name);
    require(entry != stored.end(), p.resume + ": the checkpoint is not of this program");
    T begun{};
    if constexpr (Number<T>)
      begun = to_number<T>(entry->second).value_or(value);
    else
      begun = entry->second;
    require(!line.given(name) || begun == value,
            "--" + std::string(name) + " cannot change on the way: the checkpoint has " + entry->second);
    value = begun;
  };
  take("grains", p.grains);
  take("friction", p.friction);
  take("poisson", p.poisson);
  take("cells", p.cells);
  take("element", p.element);
  take("seed", p.seed);
  if (!line.given("every")) take("every", p.every);
}

template <int Dim, template <int> class Element>
int run_compaction(const CompactionParameters& parameters, const Mesh<Dim>& mesh, const Json& summary,
                   const std::optional<StoredState<Dim>>& stored) {
  CompactionProgram<Dim, Element> program(parameters, mesh, summary);
  return stored ? program.resume(*stored) : program.start();
}

/// The body of compact_spheres and compact_disks: `unit_mesh(Index wanted_cells)` makes the reference mesh.
template <int Dim, class UnitMesh>
int compaction_program(CommandLine& line, const UnitMesh& unit_mesh) {
  CompactionParameters p;
  p.cells = Dim == 2 ? 100 : 808;
  line.option("grains", p.grains, at_least(1), "number of grains");
  line.option("friction", p.friction, at_least(0), "between grains; walls have none");
  line.option("poisson", p.poisson, strictly_between(-1, 0.5), "Poisson's ratio");
  line.option("cells", p.cells, at_least(Dim == 2 ? 64 : 32), "linear elements a grain, nearest there is");
  line.option("until", p.until, strictly_between(0, 1.2), "packing fraction to reach");
  line.option("resume", p.resume, "checkpoint to go on from; its folder's curve.csv is continued in --out");
  line.option("every", p.every, strictly_between(0, 1), "packing fraction between records");
  line.option("element", p.element, Array<std::string>{"linear", "macro", "resisting"}, "finite element");
  line.option("out", p.out, "folder for curve.csv, packing.pvd, checkpoint.jpk, summary.json, pictures");
  line.option("threads", p.threads, from_to(1, 4096), "threads");
  line.option("seed", p.seed, at_least(0), "of the random packing");
  if (!line.parse()) return 0;
  std::optional<StoredState<Dim>> stored;
  if (!p.resume.empty()) {
    const AnyStoredState any = read_checkpoint(p.resume);
    require(std::holds_alternative<StoredState<Dim>>(any),
            p.resume + ": the checkpoint is of " + (Dim == 2 ? "spheres" : "disks"));
    stored = std::get<StoredState<Dim>>(any);
    take_over(line, p, stored->parameters);
  }
  make_output_folder(p.out);
  Json summary = Json::object();
  summary["program"] = line.program();
  summary["version"] = "0.1.0";
  summary["compiler"] = __VERSION__;
  summary["parameters"] = line.parameters();
  summary["sigma0_over_E"] = preparation_stress;
  const Mesh<Dim> mesh = unit_mesh(p.cells);
  if (p.element == "linear") return run_compaction<Dim, LinearSimplex>(p, mesh, summary, stored);
  if (p.element == "resisting") return run_compaction<Dim, ResistingSimplex>(p, mesh, summary, stored);
  return run_compaction<Dim, MacroSimplex>(p, mesh, summary, stored);
}

}  // namespace jampack
