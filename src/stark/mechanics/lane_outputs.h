// What the kernel of a batch gives for all of its elements, as lanes, on several threads.
#pragma once

#include <span>

#include <stark/base/aligned.h>
#include <stark/base/thread_pool.h>
#include <stark/mechanics/quadrature_batch.h>

namespace stark {

/// Blocks of lanes with the outputs of each, as the kernel writes them; of elements with quadrature points,
/// lanes are points. pool: may be null.
AlignedVector<double> lane_outputs(const PotentialBatch& batch, symbolic::Order order,
                                   std::span<const Vec3> x, ThreadPool* pool);
AlignedVector<double> lane_outputs(const QuadratureBatch& batch, symbolic::Order order,
                                   std::span<const Vec3> x, ThreadPool* pool);

}  // namespace stark
