// Which pairs the slabs of a triangle that is large beside the other's group may keep apart, in double
// precision: see collision/slab.h.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include <stark/collision/candidates.h>
#include <stark/collision/slab.h>

namespace stark::test {

class SlabOracle {
 public:
  SlabOracle(const SurfaceMesh& mesh, std::span<const Vec3> x0, std::span<const Vec3> x1,
             const std::vector<double>& inflation)
      : mesh_(mesh), x0_(x0), x1_(x1), inflation_(inflation) {
    std::vector<std::vector<int32_t>> vertices(inflation.size());
    for (int32_t v = 0; v < mesh.vertex_count; ++v) vertices[mesh.vertex_group[v]].push_back(v);
    for (const auto& group : vertices) extent_.push_back(group.empty() ? 0.0 : extent(group));
  }

  /// Whether some triangle that has all of `a` may be kept from `b`, or the other way round.
  bool may_part(std::span<const int32_t> a, std::span<const int32_t> b) const {
    return may_part_first(a, b) || may_part_first(b, a);
  }

 private:
  // Rounding of coordinates of a few metres and of what they make of the normal [m].
  static constexpr double kRounding = 2e-5;
  static constexpr double kLargePart = 0.25;

  double radius(int32_t v) const { return inflation_[mesh_.vertex_group[v]]; }

  // Sum of the sides of the box of the start.
  double extent(std::span<const int32_t> vertices) const {
    double total = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      double low = HUGE_VAL, high = -HUGE_VAL;
      for (const int32_t v : vertices) {
        low = std::min(low, x0_[v][axis] - radius(v));
        high = std::max(high, x0_[v][axis] + radius(v));
      }
      total += high - low;
    }
    return total;
  }

  bool may_part_first(std::span<const int32_t> a, std::span<const int32_t> b) const {
    for (const Index3& t : mesh_.triangles) {
      const bool holds =
          std::ranges::all_of(a, [&](int32_t v) { return v == t[0] || v == t[1] || v == t[2]; });
      if (!holds || extent(t) < kLargePart * extent_[mesh_.vertex_group[b[0]]] - kRounding) continue;
      const Vec3 u = middle(t[1]) - middle(t[0]), v = middle(t[2]) - middle(t[0]), n = cross(u, v);
      Vec3 longest = u;
      for (const Vec3& edge : {v, v - u})
        if (squared_norm(edge) > detail::kLonger * squared_norm(longest)) longest = edge;
      for (const Vec3& direction : {n, n * -1.0, cross(n, longest), cross(longest, n)})
        if (separates(t, b, normalized(direction))) return true;
    }
    return false;
  }

  Vec3 middle(int32_t v) const { return (x0_[v] + x1_[v]) * 0.5; }

  // Whether all of b stays on one side of the triangle by more than the reach along a direction.
  bool separates(const Index3& t, std::span<const int32_t> b, const Vec3& n) const {
    const double widening = std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z);  // of boxes along it
    double start = HUGE_VAL, motion = HUGE_VAL;
    for (const int32_t v : t) {
      for (const int32_t w : b) {
        start = std::min(start, dot(n, x0_[w] - x0_[v]) - widening * (radius(v) + radius(w)));
        motion = std::min(motion, dot(n, (x1_[w] - x0_[w]) - (x1_[v] - x0_[v])));
      }
    }
    return start + std::min(0.0, motion) > -kRounding;
  }

  const SurfaceMesh& mesh_;
  std::span<const Vec3> x0_, x1_;
  std::vector<double> inflation_, extent_;
};

}  // namespace stark::test
