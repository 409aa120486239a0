// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <jampack/detection/ball_gaps.hpp>
#include <tuple>

namespace jampack {

/// A contact and the force it carries.
template <int Dim>
struct BallForce {
  BallGap<Dim> contact;
  Vector<Dim> force = Vector<Dim>::Zero();  ///< on the candidate, global axes; - force acts on the antagonist
};

/// The forces of the last step, found again by pair: the first guess of the next contact problem. Forces, not
/// impulses, so that the step may change; in global axes, so that a local frame may turn or flip.
template <int Dim>
class BallWarmStart {
 public:
  /// Takes the place of what was remembered; contacts without force are forgotten.
  void remember(const Array<BallForce<Dim>>& forces) {
    remembered_.clear();
    for (const auto& entry : forces)
      if (!entry.force.isZero(0.0)) remembered_.push_back(entry);
    std::sort(remembered_.begin(), remembered_.end(),
              [](const auto& a, const auto& b) { return key(a.contact) < key(b.contact); });
  }

  /// The force this pair carried, zero when it carried none or was not in contact.
  Vector<Dim> force(const BallGap<Dim>& contact) const {
    const auto found =
        std::lower_bound(remembered_.begin(), remembered_.end(), key(contact),
                         [](const auto& entry, const Key& k) { return key(entry.contact) < k; });
    if (found == remembered_.end() || key(found->contact) != key(contact)) return Vector<Dim>::Zero();
    return found->force;
  }

  void forget() { remembered_.clear(); }

 private:
  using Key = std::tuple<Index, Index, Index>;
  static Key key(const BallGap<Dim>& contact) {
    return {contact.candidate, contact.antagonist, contact.wall};
  }

  Array<BallForce<Dim>> remembered_;
};

}  // namespace jampack
