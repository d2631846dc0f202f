// Candidates that boxes let through although they are far apart.
#pragma once

#include <span>

#include <stark/base/thread_pool.h>
#include <stark/collision/candidates.h>

namespace stark {

/// Removes candidates whose distance at x is above the sum of their groups' reach [m]: boxes overlap far more
/// often than primitives are near, and a list is read many times.
void remove_distant(const SurfaceMesh& mesh, std::span<const double> group_reach, std::span<const Vec3> x,
                    ThreadPool& pool, CandidateList& candidates);

}  // namespace stark
