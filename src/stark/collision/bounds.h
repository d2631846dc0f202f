// Bounds of points along the axes.
#pragma once

#include <algorithm>
#include <cmath>

#include <stark/base/math.h>

namespace stark {

struct Bounds {
  Vec3 low{HUGE_VAL, HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};

  void add(const Vec3& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  void add(const Bounds& other) {
    low = {std::min(low.x, other.low.x), std::min(low.y, other.low.y), std::min(low.z, other.low.z)};
    high = {std::max(high.x, other.high.x), std::max(high.y, other.high.y), std::max(high.z, other.high.z)};
  }
  bool contains(const Vec3& p) const {
    return low.x <= p.x && low.y <= p.y && low.z <= p.z && p.x <= high.x && p.y <= high.y && p.z <= high.z;
  }
  bool overlaps(const Bounds& other) const {
    return low.x <= other.high.x && other.low.x <= high.x && low.y <= other.high.y && other.low.y <= high.y &&
           low.z <= other.high.z && other.low.z <= high.z;
  }
};

/// By a distance in all directions.
inline Bounds enlarged(const Bounds& bounds, double by) {
  const Vec3 reach{by, by, by};
  return {bounds.low - reach, bounds.high + reach};
}

}  // namespace stark
