// Collision primitives of groups of vertices with their broad phase, for queries outside of any simulation:
// who is near whom, how far a motion is safe, what intersects.
#pragma once

#include <span>
#include <vector>

#include <stark/base/thread_pool.h>
#include <stark/collision/broad_phase.h>
#include <stark/collision/intersection.h>
#include <stark/collision/max_safe_step.h>

namespace stark {

/// Positions are those of all vertices [m]; InvalidArgument where there are more or fewer. Not for two
/// threads at once.
class CollisionSet {
 public:
  /// Edges and triangles are of the groups of their vertices; `excluded` are pairs of groups that may meet.
  /// Throws InvalidMesh as validate() of surfaces.
  CollisionSet(std::vector<int32_t> vertex_group, std::vector<Index2> edges, std::vector<Index3> triangles,
               std::vector<int32_t> points = {}, std::span<const Index2> excluded = {}, int threads = 1);

  /// Pairs that can come within the sum of their groups' inflations [m] on the way from x0 to x1.
  CandidateList find(std::span<const Vec3> x0, std::span<const Vec3> x1, std::span<const double> inflation);
  /// The part of the motion on which pairs keep the sum of their groups' separations [m].
  CcdReport max_safe_step(std::span<const Vec3> x0, std::span<const Vec3> x1,
                          std::span<const double> separation);
  std::vector<EdgeTriangleIntersection> find_intersections(std::span<const Vec3> x);
  std::vector<ContainedGroup> find_contained_groups(std::span<const Vec3> x);

 private:
  void check_count(const char* name, std::span<const Vec3> x) const;

  ThreadPool pool_;
  BroadPhase broad_phase_;
};

}  // namespace stark
