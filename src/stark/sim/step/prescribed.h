// Bodies whose motion is prescribed, and which of them meet. Nothing solves for them, so a step that brings
// one into or through another cannot be prevented: it is found out, and reported. Phase: end of a step.
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <span>
#include <vector>

#include <stark/base/thread_pool.h>
#include <stark/collision/broad_phase.h>
#include <stark/sim/scene/scene.h>

namespace stark {

/// Pairs of rigid bodies that are fixed or scripted, at least one of them scripted, with contact that is not
/// disabled. Bodies that touch do not meet: overlaps count from a millionth of the smaller body on.
class PrescribedBodies {
 public:
  using Pair = std::array<int32_t, 2>;

  PrescribedBodies() = default;
  /// `surface`: of all bodies, groups are their numbers.
  PrescribedBodies(const Scene& scene, const SurfaceMesh& surface);

  /// Positions of all sites at a fraction of the way [m].
  using Path = std::function<std::vector<Vec3>(double)>;
  /// Pairs that overlap at the end of a path from start to end, or pass through each other on it; sorted.
  std::vector<Pair> find_meetings(std::span<const Vec3> start, std::span<const Vec3> end, const Path& path,
                                  ThreadPool& pool);

  struct Box {
    Vec3 low{HUGE_VAL, HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};

    void add(const Vec3& p) {
      for (int k = 0; k < 3; ++k) low[k] = std::fmin(low[k], p[k]), high[k] = std::fmax(high[k], p[k]);
    }
    void enlarge(double margin) {
      for (int k = 0; k < 3; ++k) low[k] -= margin, high[k] += margin;
    }
    double size() const { return norm(high - low); }
    bool overlaps(const Box& b) const {
      for (int k = 0; k < 3; ++k)
        if (low[k] > b.high[k] || b.low[k] > high[k]) return false;
      return true;
    }
    bool contains(const Box& b) const {
      for (int k = 0; k < 3; ++k)
        if (low[k] > b.low[k] || b.high[k] > high[k]) return false;
      return true;
    }
  };

 private:
  /// What two bodies have between them.
  struct Local {
    SurfaceMesh mesh;
    PairFilter filter;
    Pair pair;
  };

  PairFilter only(const Pair& pair) const;
  /// Primitives of two bodies that come into a region on their way.
  SurfaceMesh part_between(const Pair& pair, const Box& region, std::span<const Vec3> start,
                           std::span<const Vec3> end) const;
  /// Whether they intersect at x and no small motion parts them.
  bool overlap(const Local& local, std::span<const Vec3> x, ThreadPool& pool) const;
  /// Whether one is inside the other at x; their boxes are a and b.
  bool contains(const Pair& pair, const Box& a, const Box& b, std::span<const Vec3> x,
                ThreadPool& pool) const;
  /// Whether they are apart at the start and collide on the way, but for its very end.
  bool pass_through(const Local& local, std::span<const Vec3> start, std::span<const Vec3> end,
                    const Path& path, ThreadPool& pool) const;

  int32_t group_count_ = 0;
  std::vector<Pair> pairs_;
  std::vector<bool> is_filled_;              ///< by body
  std::vector<std::vector<int32_t>> sites_;  ///< by body; none of those that are in no pair
  std::vector<double> touch_;                ///< by body: a millionth of its size [m]
  SurfaceMesh mesh_;                         ///< of the bodies in pairs
};

}  // namespace stark
