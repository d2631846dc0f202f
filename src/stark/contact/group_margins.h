// Margins of groups that are far from all that they may touch: their sites may move as far as the gaps allow
// before their pairs are looked for anew (step phases 2, 4b and 4h). Rigid bodies of thousands of triangles
// on their way through empty space then cost no search.
#pragma once

#include <span>
#include <vector>

#include <stark/collision/bounds.h>
#include <stark/collision/candidates.h>

namespace stark {

class GroupMargins {
 public:
  GroupMargins() = default;
  /// By group [m]: the distance within which it acts, and its margin where something may be near.
  GroupMargins(std::span<const double> distance, std::span<const double> least)
      : distance_(distance.begin(), distance.end()), least_(least.begin(), least.end()) {}

  std::span<const double> least() const { return least_; }

  /// The margins of groups within these bounds. Two groups that may touch never come within the sum of their
  /// distances while their sites stay within their margins.
  std::vector<double> wide(const PairFilter& filter, std::span<const Bounds> bounds) const;

 private:
  /// More is not worth looking for [m].
  double most(int32_t group) const;

  std::vector<double> distance_, least_;
};

}  // namespace stark
