// Intersections at rest: edges through triangles (exact) and bodies inside others; distances of bodies.
// Phase: check of states that do not come from a step.
#pragma once

#include <limits>
#include <memory>
#include <span>
#include <vector>

#include <stark/base/thread_pool.h>
#include <stark/collision/candidates.h>

namespace stark {

struct EdgeTriangleIntersection {
  int32_t edge, triangle;
  bool operator==(const EdgeTriangleIntersection&) const = default;
};

/// `inner` has a connected piece, with first vertex `vertex`, that starts inside the closed surface of
/// `outer`.
struct ContainedGroup {
  int32_t inner, outer, vertex;
  bool operator==(const ContainedGroup&) const = default;
};

/// Points of two groups that are nearest to each other, and how far apart they are [m].
struct ClosestPoints {
  double distance = std::numeric_limits<double>::infinity();
  Vec3 point_a{}, point_b{};
};

/// Finds both for the same surfaces at different places: what depends on the topology alone is kept from
/// search to search. Not for two threads at once.
class IntersectionFinder {
 public:
  /// `is_filled`: by group, whether it fills its closed surface; none given: all do.
  IntersectionFinder(SurfaceMesh mesh, int32_t group_count, std::vector<bool> is_filled = {});
  ~IntersectionFinder();
  IntersectionFinder(const IntersectionFinder&) = delete;
  IntersectionFinder& operator=(const IntersectionFinder&) = delete;

  /// All allowed pairs of an edge and a triangle that meet (touching counts) and share no vertex; sorted.
  std::vector<EdgeTriangleIntersection> intersections(std::span<const Vec3> x, const PairFilter& filter,
                                                      ThreadPool& pool);
  /// Allowed pairs of groups where a connected piece of one lies inside the other's surface, if that is
  /// closed and filled. Exact where intersections() finds nothing; sorted, at most one entry per pair of
  /// groups.
  std::vector<ContainedGroup> contained_groups(std::span<const Vec3> x, const PairFilter& filter,
                                               ThreadPool& pool) const;
  /// Between the surfaces of two groups, whatever a filter would say; distance 0 at a place where they meet.
  /// Infinite where one has no primitives.
  ClosestPoints closest_points(std::span<const Vec3> x, int32_t group_a, int32_t group_b, ThreadPool& pool);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// All allowed pairs of an edge and a triangle that meet (touching counts) and share no vertex; sorted.
std::vector<EdgeTriangleIntersection> find_intersections(const SurfaceMesh& mesh, std::span<const Vec3> x,
                                                         const PairFilter& filter, ThreadPool& pool);

/// Allowed pairs of groups where a connected piece of one lies inside the other's surface, if that is closed
/// and the group is filled (none given: all are). Exact where find_intersections reports nothing; sorted, at
/// most one entry per pair of groups.
std::vector<ContainedGroup> find_contained_groups(const SurfaceMesh& mesh, std::span<const Vec3> x,
                                                  const PairFilter& filter, ThreadPool& pool,
                                                  const std::vector<bool>& is_filled = {});

}  // namespace stark
