// Bodies whose motion is prescribed, and which of them meet. Nothing solves for them, so a step that brings
// one into or through another cannot be prevented: it is found out, and reported. Phase: end of a step.
#pragma once

#include <cmath>
#include <functional>
#include <set>
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
  using Pair = Scene::Pair;

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
  struct Body {
    int32_t number = 0;  ///< in the scene
    bool is_scripted = false, is_filled = false;
    std::vector<Index2> edges{};
    std::vector<Index3> triangles{};
    std::vector<int32_t> sites{}, inner{};  ///< sorted
    // Of the last find_meetings():
    Box place{}, way{};  ///< at the end; of the whole motion
    bool rests = true;
    double touch = 0.0;  ///< a millionth of its size [m]
  };
  /// What two bodies, as groups 0 and 1, have between them; its vertices are `sites`.
  struct Local {
    SurfaceMesh mesh{};
    PairFilter filter{};
    std::vector<int32_t> sites{};
    bool has_both = false;
    std::vector<Vec3> gather(std::span<const Vec3> x) const;
  };
  /// Positions of all sites at the ends of parts of the way, found where they are asked for.
  struct Stations {
    const Path& path;
    std::vector<std::vector<Vec3>> x;
    const std::vector<Vec3>& at(int k);
  };

  static bool meet(const Body& a, const Body& b, std::span<const Vec3> start, std::span<const Vec3> end,
                   Stations& stations, ThreadPool& pool);
  /// Primitives of two bodies that come into the region which their ways have in common.
  static Local part_between(const Body& a, const Body& b, std::span<const Vec3> start,
                            std::span<const Vec3> end);
  template <typename IsWanted>
  static Local make_local(const Body& a, const Body& b, IsWanted&& is_wanted);
  /// Whether they intersect at the end, and no motion by `way` [m] parts them.
  static bool overlap(const Local& local, std::span<const Vec3> end, double way, ThreadPool& pool);
  /// Whether one is inside the other at x.
  static bool contains(const Body& a, const Body& b, std::span<const Vec3> x, ThreadPool& pool);
  /// Whether they are apart at the start and collide on the way, but for its very end.
  static bool pass_through(const Local& local, const std::vector<double>& touch, std::span<const Vec3> start,
                           Stations& stations, ThreadPool& pool);

  std::vector<Body> bodies_;  ///< fixed and scripted ones with surfaces; none where none is scripted
  std::set<Pair> without_;    ///< without contact, or with a joint that keeps them from it
};

}  // namespace stark
