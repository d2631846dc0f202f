// The largest part of a motion before any pair of candidates collides. Phase: step-length bound.
#pragma once

#include <optional>
#include <span>

#include <stark/base/thread_pool.h>
#include <stark/collision/candidates.h>
#include <stark/collision/ccd.h>

namespace stark {

/// What limited a step and how much work it was.
struct CcdReport {
  double step = 1.0;
  std::optional<PairKind> kind;     ///< of the pair that limits
  int64_t candidate = -1;           ///< index into the list of that kind
  int32_t first = -1, second = -1;  ///< ids of the two primitives
  int64_t tested = 0;               ///< candidates that needed more than the box test
};

/// Smallest safe fraction over all candidates, for vertices that move linearly from x0 to x1. The list must
/// hold every pair that can come within min_separation [m] on the way (BroadPhase::find_swept, or a list
/// whose motion budget covers the motion).
double max_safe_step(const SurfaceMesh& mesh, const CandidateList& candidates, std::span<const Vec3> x0,
                     std::span<const Vec3> x1, double min_separation, ThreadPool& pool,
                     CcdReport* out_report = nullptr, const CcdSettings& settings = {});

/// What pairs of primitives keep [m]: the sum of their two groups' values, or that of their groups together.
struct Separations {
  struct Pair {
    int32_t low, high;  ///< groups, low <= high
    double separation;
  };
  std::span<const double> by_group;
  std::span<const Pair> by_pair = {};  ///< instead of the sum; sorted by groups
  /// By group [m], none where no group has one. Barriers of pairs with a core are infinite at a part of the
  /// separation. Pairs that have come to it keep that part: a barrier that ends in a wall carries no more
  /// than it does there.
  std::span<const double> core = {};
  double core_part = 1.0;

  double operator()(int32_t group_a, int32_t group_b) const;
  bool is_core(int32_t group_a, int32_t group_b) const;
};

/// As above with separations by group.
double max_safe_step(const SurfaceMesh& mesh, const CandidateList& candidates, std::span<const Vec3> x0,
                     std::span<const Vec3> x1, const Separations& separations, ThreadPool& pool,
                     CcdReport* out_report = nullptr, const CcdSettings& settings = {});

}  // namespace stark
