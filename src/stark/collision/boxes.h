// Boxes for the broad phase, one and eight at a time, at rest and in motion; not part of the public
// interface. Single precision about a common origin, rounded outwards.
//
// Primitives that move have two boxes, that of their start and that of their displacements. Two of them can
// meet only if the first box of one overlaps that of the other, stretched by the range of their relative
// displacements: what moves along with its neighbours, a cloth that spins or falls, finds as few pairs as if
// it stood still.
#pragma once

#include <cstdint>
#include <limits>

namespace stark::detail {

inline constexpr int kWidth = 8;
using Float4 = float __attribute__((vector_size(16)));
using Int4 = int32_t __attribute__((vector_size(16)));
using Float8 = float __attribute__((vector_size(32)));
using Int8 = int32_t __attribute__((vector_size(32)));

/// Eight boxes, structure of arrays.
struct alignas(64) BoxNode {
  Float8 low[3], high[3];
};

/// One box; the fourth components are 0.
struct Box {
  Float4 low, high;

  bool overlaps(const Box& b) const {
    const Int4 inside = (low <= b.high) & (b.low <= high);
#if defined(__SSE__)
    return __builtin_ia32_movmskps(reinterpret_cast<Float4>(inside)) == 15;
#else
    return (inside[0] & inside[1] & inside[2]) != 0;
#endif
  }
};

inline constexpr float kInfinity = std::numeric_limits<float>::infinity();
inline constexpr Box kEmptyBox = {{kInfinity, kInfinity, kInfinity, 0.0f},
                                  {-kInfinity, -kInfinity, -kInfinity, 0.0f}};

inline Float4 min(const Float4& a, const Float4& b) { return a < b ? a : b; }
inline Float4 max(const Float4& a, const Float4& b) { return a > b ? a : b; }

inline Box merge(const Box& a, const Box& b) { return {min(a.low, b.low), max(a.high, b.high)}; }

/// Where something is at the start, and the range of displacements of its points.
struct MovingBox {
  Box start, motion;

  bool overlaps(const MovingBox& b) const {
    const Float4 zero{};
    return start.overlaps({b.start.low + min(b.motion.low - motion.high, zero),
                           b.start.high + max(b.motion.high - motion.low, zero)});
  }
};

inline MovingBox merge(const MovingBox& a, const MovingBox& b) {
  return {merge(a.start, b.start), merge(a.motion, b.motion)};
}

inline int lane_mask(const Int8& inside) {
#if defined(__AVX__)
  return __builtin_ia32_movmskps256(reinterpret_cast<Float8>(inside));
#else
  int mask = 0;
  for (int k = 0; k < kWidth; ++k) mask |= (inside[k] & 1) << k;
  return mask;
#endif
}

/// Bit k set where box k of the node overlaps the box.
inline int overlap_mask(const BoxNode& node, const Box& box) {
  Int8 inside = (node.low[0] <= box.high[0]) & (node.high[0] >= box.low[0]);
  inside &= (node.low[1] <= box.high[1]) & (node.high[1] >= box.low[1]);
  inside &= (node.low[2] <= box.high[2]) & (node.high[2] >= box.low[2]);
  return lane_mask(inside);
}

/// The same of boxes that move; `motion`: displacements of those of the node.
inline int overlap_mask(const BoxNode& start, const BoxNode& motion, const MovingBox& box) {
  const Float8 zero{};
  Int8 inside = zero == zero;
  for (int axis = 0; axis < 3; ++axis) {
    const Float8 back = motion.low[axis] - box.motion.high[axis];
    const Float8 forth = motion.high[axis] - box.motion.low[axis];
    inside &= start.low[axis] + (back < zero ? back : zero) <= box.start.high[axis];
    inside &= start.high[axis] + (forth > zero ? forth : zero) >= box.start.low[axis];
  }
  return lane_mask(inside);
}

}  // namespace stark::detail
