// Distances that pairs of groups are known to keep. Relative motion uses them up: until then the groups
// cannot meet, whatever their shape, and nobody needs to look at their primitives. Not part of the public
// interface.
#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>

#include <stark/collision/bounds.h>

namespace stark::detail {

/// Part of their relative motion that groups have to stay apart beyond a distance: what is nearer is left to
/// continuous detection, so that its steps do not depend on which pairs were known to be apart.
constexpr double kSpareMotion = 0.25;

class GroupClearances {
 public:
  bool empty() const { return least_.empty(); }
  void clear() { least_.clear(); }

  /// The groups are at least this far apart where they are now [m].
  void set(int32_t group_a, int32_t group_b, double distance);

  /// The vertices of each group have moved, by displacements within these bounds [m].
  void move(std::span<const Bounds> displacements);

  /// Whether the groups are farther apart than `distance` [m] on all of a way on which each vertex moves
  /// straight: from displacements within the bounds of `start` to ones within those of `end`, both from where
  /// the groups are now; none: nothing moves.
  bool are_apart(int32_t group_a, int32_t group_b, double distance, std::span<const Bounds> start,
                 std::span<const Bounds> end) const;

 private:
  std::unordered_map<int64_t, double> least_;  // by pair [m]
};

}  // namespace stark::detail
