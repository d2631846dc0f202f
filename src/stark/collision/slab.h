// The slabs about a triangle, for the broad phase; not part of the public interface. The box of a large
// triangle that is not parallel to the axes holds much that is nowhere near it: along its normal it is as
// thin as its contact distance, and across its longest edge no wider than its height. Any direction gives a
// valid bound, so both may be as inexact as they like.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

#include <stark/collision/boxes.h>

namespace stark::detail {

struct Slab {
  Float4 up{}, down{};  ///< positive and negative components of its direction, whose absolute ones sum to 1
  float low = -std::numeric_limits<float>::infinity(), high = std::numeric_limits<float>::infinity();
  float motion_low = 0.0f, motion_high = 0.0f;  ///< of displacements along it
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

inline Float4 cross(const Float4& a, const Float4& b) {
  return Float4{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0], 0.0f};
}
/// Sum of the absolute components.
inline float size_of(const Float4& a) { return std::fabs(a[0]) + std::fabs(a[1]) + std::fabs(a[2]); }

/// The slab along a direction that holds what three vertices with these boxes span, wider by `rounding` [m],
/// which covers all sums of products of coordinates and components of directions. Of all space where there is
/// no direction.
template <typename Extent>
Slab slab_along(const Float4& direction, const Extent (&vertices)[3], float rounding) {
  const float size = size_of(direction);
  Slab slab;
  if (!(size > 1e-30f && size < 1e30f)) return slab;
  slab.up = max(direction / size, Float4{});
  slab.down = min(direction / size, Float4{});
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

constexpr float kLonger = 1.02f;

/// Those along the normal of a triangle, and in its plane across its longest edge.
using TriangleSlabs = std::array<Slab, 2>;
template <typename Extent>
TriangleSlabs slabs_of(const Extent (&vertices)[3], float rounding) {
  const Float4 origin = twice_middle(vertices[0]);
  const Float4 u = twice_middle(vertices[1]) - origin, v = twice_middle(vertices[2]) - origin;
  const Float4 normal = cross(u, v), w = v - u;
  Float4 longest = u;  // of about the same, always the same, whatever rounding says
  for (const Float4& edge : {v, w})
    if (sum(edge * edge) > kLonger * sum(longest * longest)) longest = edge;
  return {slab_along(normal, vertices, rounding),
          slab_along(cross(normal / size_of(normal), longest / size_of(longest)), vertices, rounding)};
}

/// Slabs of the triangles that were asked for last: what lies on a few large ones asks for them again and
/// again.
class RecentSlabs {
 public:
  void forget() { numbers_.fill(-1); }
  template <typename Make>
  const TriangleSlabs& of(int32_t number, Make&& make) {
    const size_t place = static_cast<size_t>(number) % kCount;
    if (numbers_[place] != number) {
      slabs_[place] = make();
      numbers_[place] = number;
    }
    return slabs_[place];
  }

 private:
  static constexpr size_t kCount = 64;
  std::array<int32_t, kCount> numbers_{};
  std::array<TriangleSlabs, kCount> slabs_{};
};

/// Whether a slab keeps a box away from its triangle. Numbers that are not finite keep nothing away.
inline bool is_separated(const Slab& slab, const Box& box) {
  return lowest(slab, box) > slab.high || highest(slab, box) < slab.low;
}
/// The same of a box that moves, all the way: gaps of pairs of vertices along the slab are linear in time.
inline bool is_separated(const Slab& slab, const MovingBox& box) {
  const float back = lowest(slab, box.motion) - slab.motion_high,
              forth = highest(slab, box.motion) - slab.motion_low;
  return lowest(slab, box.start) + std::min(0.0f, back) > slab.high ||
         highest(slab, box.start) + std::max(0.0f, forth) < slab.low;
}

/// Least and largest coordinate along the slab of eight boxes.
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

/// Bit k set where the slab keeps box k of the node away from its triangle.
inline int separated_mask(const BoxNode& node, const Slab& slab) {
  const Interval8 way = along(slab, node);
  return lane_mask((way.low > slab.high) | (way.high < slab.low));
}

/// The same of boxes that move.
inline int separated_mask(const BoxNode& start, const BoxNode& motion, const Slab& slab) {
  const Interval8 way = along(slab, start), moved = along(slab, motion);
  const Float8 zero{};
  const Float8 back = moved.low - slab.motion_high, forth = moved.high - slab.motion_low;
  return lane_mask((way.low + (back < zero ? back : zero) > slab.high) |
                   (way.high + (forth > zero ? forth : zero) < slab.low));
}

}  // namespace stark::detail
