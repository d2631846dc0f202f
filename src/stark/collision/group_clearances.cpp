#include <stark/collision/group_clearances.h>

#include <algorithm>
#include <cmath>

namespace stark::detail {

namespace {

constexpr double kRounding = 1e-9;  ///< relative

int64_t code_of(int32_t a, int32_t b) {
  return static_cast<int64_t>(std::max(a, b)) << 32 | static_cast<int64_t>(std::min(a, b));
}

/// Largest relative displacement of a vertex of one group and one of the other [m].
double relative_motion(const Bounds& a, const Bounds& b) {
  double squared = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double most = std::max(a.high[axis] - b.low[axis], b.high[axis] - a.low[axis]);
    squared += most * most;
  }
  return std::sqrt(squared) * (1.0 + kRounding);
}

}  // namespace

void GroupClearances::set(int32_t group_a, int32_t group_b, double distance) {
  least_[code_of(group_a, group_b)] = distance;
}

void GroupClearances::move(std::span<const Bounds> displacements) {
  for (auto& [code, least] : least_)
    least -= relative_motion(displacements[code >> 32], displacements[static_cast<int32_t>(code)]);
  std::erase_if(least_, [](const auto& entry) { return !(entry.second > 0.0); });
}

bool GroupClearances::are_apart(int32_t group_a, int32_t group_b, double distance,
                                std::span<const Bounds> start, std::span<const Bounds> end) const {
  const auto entry = least_.find(code_of(group_a, group_b));
  if (entry == least_.end()) return false;
  double motion = 0.0;  // relative displacements are largest at one of the ends
  for (const std::span<const Bounds> at : {start, end})
    if (!at.empty()) motion = std::max(motion, relative_motion(at[group_a], at[group_b]));
  return entry->second - (1.0 + kSpareMotion) * motion > distance * (1.0 + kRounding);
}

}  // namespace stark::detail
