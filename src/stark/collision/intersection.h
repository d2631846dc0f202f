// Intersections at rest: edges through triangles (exact) and bodies inside others. Phase: check of the
// initial state and of accepted steps in verify mode.
#pragma once

#include <span>
#include <vector>

#include <stark/base/thread_pool.h>
#include <stark/collision/candidates.h>

namespace stark {

struct EdgeTriangleIntersection {
  int32_t edge, triangle;
  bool operator==(const EdgeTriangleIntersection&) const = default;
};

/// All allowed pairs of an edge and a triangle that meet (touching counts) and share no vertex; sorted.
std::vector<EdgeTriangleIntersection> find_intersections(const SurfaceMesh& mesh, std::span<const Vec3> x,
                                                         const PairFilter& filter, ThreadPool& pool);

/// `inner` has a connected piece, with first vertex `vertex`, that starts inside the closed surface of
/// `outer`.
struct ContainedGroup {
  int32_t inner, outer, vertex;
  bool operator==(const ContainedGroup&) const = default;
};

/// Allowed pairs of groups where a connected piece of one lies inside the other's surface, if that is closed
/// and the group is filled (none given: all are). Exact where find_intersections reports nothing; sorted, at
/// most one entry per pair of groups.
std::vector<ContainedGroup> find_contained_groups(const SurfaceMesh& mesh, std::span<const Vec3> x,
                                                  const PairFilter& filter, ThreadPool& pool,
                                                  const std::vector<bool>& is_filled = {});

}  // namespace stark
