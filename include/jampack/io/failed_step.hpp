// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/io/contact_problem_text.hpp>
#include <jampack/stepping/soft_step.hpp>

namespace jampack {

/// Writes the contact problem before which the last step was given up, with the forces it had reached as
/// guess. False, and no file, where the last step was not given up or a grain cannot be linearised there.
/// Throws Error if it cannot write.
template <class Packing, ContactLaw Law, class Solver, class Discretisation>
bool write_failed_step(const std::filesystem::path& path,
                       SoftStep<Packing, Law, Solver, Discretisation>& step) {
  const auto failed = step.failed_contact_problem();
  if (!failed) return false;
  write_contact_problem(path, failed->problem, failed->guess);
  return true;
}

}  // namespace jampack
