// The slab about a triangle, for the broad phase; not part of the public interface. The box of a large
// triangle that is not parallel to the axes holds much that is nowhere near it: along its normal it is as
// thin as its contact distance. Any direction gives a valid bound, so the normal may be as inexact as it
// likes.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include <stark/collision/boxes.h>

namespace stark::detail {

struct Slab {
  Float4 up{}, down{};  ///< positive and negative components of the normal, whose absolute ones sum to 1
  float low = -std::numeric_limits<float>::infinity(), high = std::numeric_limits<float>::infinity();
  float motion_low = 0.0f, motion_high = 0.0f;  ///< of displacements along the normal
};

inline float sum(const Float4& a) { return a[0] + a[1] + a[2]; }
inline float lowest(const Slab& slab, const Box& box) {
  return sum(slab.up * box.low + slab.down * box.high);
}
inline float highest(const Slab& slab, const Box& box) {
  return sum(slab.up * box.high + slab.down * box.low);
}

inline Float4 twice_middle(const Box& box) { return box.low + box.high; }
inline Float4 twice_middle(const MovingBox& box) {
  return twice_middle(box.start) + 0.5f * twice_middle(box.motion);
}
inline const Box& start_of(const Box& box) { return box; }
inline const Box& start_of(const MovingBox& box) { return box.start; }

/// The slab that holds what three vertices with these boxes span, wider by `rounding` [m], which covers all
/// sums of products of coordinates and components of the normal. Of all space where there is no normal.
template <typename Extent>
Slab slab_of(const Extent (&vertices)[3], float rounding) {
  const Float4 origin = twice_middle(vertices[0]);
  const Float4 u = twice_middle(vertices[1]) - origin, v = twice_middle(vertices[2]) - origin;
  const Float4 normal = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0],
                         0.0f};
  const float size = std::fabs(normal[0]) + std::fabs(normal[1]) + std::fabs(normal[2]);
  Slab slab;
  if (!(size > 1e-30f && size < 1e30f)) return slab;
  slab.up = max(normal / size, Float4{});
  slab.down = min(normal / size, Float4{});
  for (int k = 0; k < 3; ++k) {
    const float low = lowest(slab, start_of(vertices[k])), high = highest(slab, start_of(vertices[k]));
    slab.low = k == 0 ? low : std::min(slab.low, low);
    slab.high = k == 0 ? high : std::max(slab.high, high);
    if constexpr (std::is_same_v<Extent, MovingBox>) {
      const float back = lowest(slab, vertices[k].motion), forth = highest(slab, vertices[k].motion);
      slab.motion_low = k == 0 ? back : std::min(slab.motion_low, back);
      slab.motion_high = k == 0 ? forth : std::max(slab.motion_high, forth);
    }
  }
  slab.low -= rounding;
  slab.high += rounding;
  return slab;
}

/// Least and largest coordinate along the normal of eight boxes.
struct Interval8 {
  Float8 low, high;
};
inline Interval8 along(const Slab& slab, const BoxNode& node) {
  Interval8 interval{slab.up[0] * node.low[0] + slab.down[0] * node.high[0],
                     slab.up[0] * node.high[0] + slab.down[0] * node.low[0]};
  for (int axis = 1; axis < 3; ++axis) {
    interval.low += slab.up[axis] * node.low[axis] + slab.down[axis] * node.high[axis];
    interval.high += slab.up[axis] * node.high[axis] + slab.down[axis] * node.low[axis];
  }
  return interval;
}

/// Bit k set where the slab keeps box k of the node away from its triangle. Numbers that are not finite keep
/// nothing away.
inline int separated_mask(const BoxNode& node, const Slab& slab) {
  const Interval8 way = along(slab, node);
  return lane_mask((way.low > slab.high) | (way.high < slab.low));
}

/// The same of boxes that move, all the way: gaps of pairs of vertices along the normal are linear in time.
inline int separated_mask(const BoxNode& start, const BoxNode& motion, const Slab& slab) {
  const Interval8 way = along(slab, start), moved = along(slab, motion);
  const Float8 zero{};
  const Float8 back = moved.low - slab.motion_high, forth = moved.high - slab.motion_low;
  return lane_mask((way.low + (back < zero ? back : zero) > slab.high) |
                   (way.high + (forth > zero ? forth : zero) < slab.low));
}

}  // namespace stark::detail
