// Broad phase: all pairs of primitives whose boxes, inflated per group, overlap. One bounding volume
// hierarchy per group, built once and refitted at every query; group pairs whose bounds overlap are traversed
// leaf against tree. Phase: when the motion budget of the candidate list is used up.
#pragma once

#include <memory>
#include <span>

#include <stark/base/thread_pool.h>
#include <stark/collision/candidates.h>

namespace stark {

class BroadPhase {
 public:
  BroadPhase();
  BroadPhase(BroadPhase&&) noexcept;
  BroadPhase& operator=(BroadPhase&&) noexcept;
  ~BroadPhase();

  /// Takes a new set of primitives. Throws InvalidMesh for ids out of range and inconsistent array sizes, and
  /// for primitives whose vertices are of another group.
  void reset(SurfaceMesh mesh, PairFilter filter);

  const SurfaceMesh& mesh() const;
  const PairFilter& filter() const;

  /// A new table of allowed pairs for the same primitives.
  void set_filter(PairFilter filter);

  /// All allowed pairs whose distance at positions x [m] can be <= group_inflation[a] + group_inflation[b]
  /// [m], except those that share a vertex. Which others it has depends on the primitives' boxes and on what
  /// is known of their groups' distances from earlier calls, not on threads. Positions must be finite. Reuses
  /// the capacity of `out`. moved: by vertex; where given, only pairs with a vertex where it is not 0.
  void find(std::span<const Vec3> x, std::span<const double> group_inflation, ThreadPool& pool,
            CandidateList& out, std::span<const uint8_t> moved = {});

  /// As find, for primitives that move linearly from x0 to x1: every pair that can come that near on the way.
  /// Of what moves along together hardly more than at rest: boxes are of positions at the start and of
  /// displacements, and only relative ones count.
  void find_swept(std::span<const Vec3> x0, std::span<const Vec3> x1, std::span<const double> group_inflation,
                  ThreadPool& pool, CandidateList& out, std::span<const uint8_t> moved = {});

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace stark
