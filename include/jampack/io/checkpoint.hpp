// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <filesystem>
#include <jampack/analysis/audit_state.hpp>
#include <jampack/io/checkpoint_format.hpp>
#include <jampack/io/file.hpp>
#include <variant>

namespace jampack {

/// A stored state of either dimension.
using AnyStoredState = std::variant<StoredState<2>, StoredState<3>>;

namespace detail {

inline constexpr std::string_view checkpoint_magic = "JAMPACK\n";
inline constexpr std::uint64_t checkpoint_version = 4;
inline constexpr std::size_t checkpoint_header = 8 + 4 * 8;  // magic, version, dimension, length, checksum

/// The order of everything in the file, once for writing and reading.
template <class Archive, class State>
void visit_fields(Archive& archive, State& state) {
  const auto all = [&](auto&... fields) { (archive(fields), ...); };
  const auto whole = [&](auto& index) {  // Index as the 64 bits it is in the file
    std::int64_t number = index;
    archive(number);
    if constexpr (!std::is_const_v<std::remove_reference_t<decltype(index)>>) index = Index(number);
  };
  const auto value = [&](auto& entry) { archive(entry); };
  all(state.element, state.material, state.young, state.poisson, state.density);
  whole(state.n_pair_unknowns);
  all(state.friction, state.theta);
  auto& room = state.room;
  all(room.centre, room.reference_volume, room.scale);
  archive.sequence(room.normal, value);
  archive.sequence(room.distance, value);
  auto& mesh = state.mesh;
  archive.sequence(mesh.nodes, value);
  archive.sequence(mesh.cells, value);
  archive.sequence(mesh.macros, value);
  archive.sequence(mesh.faces, [&](auto& face) {
    archive(face.node);
    whole(face.n_nodes);
  });
  archive.sequence(mesh.boundary_nodes, whole);
  archive.sequence(state.grains, [&](auto& grain) {
    all(grain.diameter, grain.rotation, grain.position, grain.velocity, grain.position_before,
        grain.velocity_before);
  });
  const auto contact_fields = [&](auto& contact) {
    whole(contact.candidate);
    whole(contact.sample);
    whole(contact.antagonist);
    whole(contact.face);
    all(contact.xi, contact.normal, contact.slack, contact.reaction);
  };
  archive.sequence(state.pairs, contact_fields);
  archive.sequence(state.walls, contact_fields);
  auto& at = state.progress;
  all(at.n_steps, at.n_iterations, at.n_failed);
  all(at.strain, at.last_duration, at.last_pressure, at.gain, at.equilibrium_residual, at.scaled_residual);
  archive(state.parameters);
}

/// Refuses a state whose parts do not fit together.
template <int Dim>
void require_consistent(const StoredState<Dim>& state) {
  const Index n_nodes = state.mesh.nodes.size(), n_grains = state.grains.size();
  const auto known = [&](Index node) { require(node >= 0 && node < n_nodes, "its mesh has no such node"); };
  for (const auto& cell : state.mesh.cells)
    for (const Index node : cell) known(node);
  for (const auto& cell : state.mesh.macros)
    for (const Index node : cell) known(node);
  for (const auto& face : state.mesh.faces) {
    require(face.n_nodes == Dim || face.n_nodes == face.n_quadratic_nodes, "its mesh has an unknown face");
    for (Index i = 0; i < face.n_nodes; ++i) known(face.node[std::size_t(i)]);
  }
  for (const Index node : state.mesh.boundary_nodes) known(node);
  require(state.room.normal.size() == state.room.distance.size(), "its walls are incomplete");
  require(std::isfinite(state.room.scale) && state.room.scale > 0, "its room is impossible");
  for (const auto& grain : state.grains)
    require(std::isfinite(grain.diameter) && grain.diameter > 0 && grain.position.cols() == n_nodes &&
                grain.velocity.cols() == n_nodes && grain.position_before.cols() == n_nodes &&
                grain.velocity_before.cols() == n_nodes,
            "a grain in it is impossible");
  const auto check = [&](const StoredContact<Dim>& contact, bool at_wall) {
    require(contact.candidate >= 0 && contact.candidate < n_grains && contact.sample >= 0 &&
                contact.is_wall() == at_wall &&
                (at_wall ? contact.wall() < state.room.n_walls()
                         : contact.antagonist < n_grains && contact.face >= 0 &&
                               contact.face < state.mesh.faces.size()),
            "a contact in it is impossible");
  };
  for (const auto& contact : state.pairs) check(contact, false);
  for (const auto& contact : state.walls) check(contact, true);
}

template <int Dim>
StoredState<Dim> read_fields(std::string_view content) {
  StoredState<Dim> state;
  CheckpointReader reader(content);
  visit_fields(reader, state);
  require(reader.at_end(), "it has more content than it should");
  require_consistent(state);
  return state;
}

}  // namespace detail

/// Writes a state so that it reads back bit for bit, atomically: an interrupted write leaves the file as it
/// was. Throws Error where the file cannot be written.
template <int Dim>
void write_checkpoint(const std::filesystem::path& path, const StoredState<Dim>& state) {
  CheckpointWriter content, header;
  detail::visit_fields(content, state);
  header.bytes = detail::checkpoint_magic;
  header(detail::checkpoint_version);
  header(std::uint64_t(Dim));
  header(static_cast<std::uint64_t>(content.bytes.size()));
  header(checksum(content.bytes));
  write_file(path, header.bytes + content.bytes);
}

/// Reads a state. Throws InvalidInput, one line that names the file, where it is missing, no checkpoint, of
/// another version, cut short or damaged.
inline AnyStoredState read_checkpoint(const std::filesystem::path& path) {
  const std::string bytes = read_file(path);
  const std::string name = path.string() + ": ";
  require(bytes.starts_with(detail::checkpoint_magic), name + "this is no jampack checkpoint");
  require(bytes.size() >= detail::checkpoint_header, name + "the checkpoint is cut short");
  CheckpointReader header(std::string_view(bytes).substr(detail::checkpoint_magic.size()));
  std::uint64_t version = 0, dimension = 0, length = 0, sum = 0;
  header(version);
  header(dimension);
  header(length);
  header(sum);
  require(version == detail::checkpoint_version,
          name + "the checkpoint has format " + std::to_string(version) + ", this program reads format " +
              std::to_string(detail::checkpoint_version));
  const std::string_view content = std::string_view(bytes).substr(detail::checkpoint_header);
  require(content.size() >= length, name + "the checkpoint is cut short: " + std::to_string(content.size()) +
                                        " of " + std::to_string(length) + " bytes are there");
  require(content.size() == length && checksum(content) == sum && (dimension == 2 || dimension == 3),
          name + "the checkpoint is damaged");
  try {
    if (dimension == 2) return detail::read_fields<2>(content);
    return detail::read_fields<3>(content);
  } catch (const InvalidInput& error) {
    throw InvalidInput(name + "the checkpoint is damaged: " + error.what());
  }
}

}  // namespace jampack
