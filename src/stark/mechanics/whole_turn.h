// Bodies of points turn as a whole: what a straight motion of their points lacks of the turn that is in it
// (step phase 4i). A Newton direction knows a turn to first order only. Taken straight it stretches a body by
// half the square of the angle, which stiff bodies allow in tiny steps alone. [theory eq. 22c]
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <stark/base/math.h>

namespace stark {

/// Points that turn together, or nodes of a rod, by their numbers in the configuration.
struct TurningRange {
  bool are_nodes = false;
  bool is_held = false;  ///< by joints or attachments
  int32_t first = 0;
  std::vector<double> masses{};  ///< of each of them [kg]

  /// Theirs among values of all points or nodes.
  template <typename Values>
  auto of(Values& values) const {
    return std::span(values).subspan(static_cast<size_t>(first), masses.size());
  }
};

/// Turns the points of one body, which alpha * direction has carried straight from `from` to `to` [m]: about
/// the centre of the prescribed ones among them; without any, about the axis that stays where it is if the
/// body is held, so that a pivot does, and else about the centre, which goes straight. `blocks` by point,
/// kNoBlock for those that are prescribed; `direction` is [block_count][3]. Masses weigh the points, some of
/// which may be free to go anywhere, as in cells that are all but empty. Returns false where the angle is too
/// small to matter.
bool complete_turn(const TurningRange& range, std::span<const Vec3> from, std::span<const int32_t> blocks,
                   std::span<const double> direction, double alpha, std::span<Vec3> to);

}  // namespace stark
