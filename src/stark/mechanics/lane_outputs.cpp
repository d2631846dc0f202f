// See lane_outputs.h.
#include <stark/mechanics/lane_outputs.h>

#include <stark/base/for_each_range.h>

namespace stark {

using symbolic::kLanes;

namespace {

constexpr int64_t kPerTask = 64;  ///< blocks of lanes, or groups of elements

}  // namespace

AlignedVector<double> lane_outputs(const PotentialBatch& batch, symbolic::Order order,
                                   std::span<const Vec3> x, ThreadPool* pool) {
  const int64_t width = batch.potential().kernel().output_count(order) * kLanes;
  AlignedVector<double> out(batch.block_count() * width);
  for_each_range(pool, batch.block_count(), kPerTask, [&](int64_t begin, int64_t end) {
    batch.evaluate(order, x, begin, end, out.data() + begin * width);
  });
  return out;
}

AlignedVector<double> lane_outputs(const QuadratureBatch& batch, symbolic::Order order,
                                   std::span<const Vec3> x, ThreadPool* pool) {
  const int64_t width = batch.output_count(order) * kLanes;
  AlignedVector<double> out(batch.law().block_count() * width);
  for_each_range(pool, batch.group_count(), kPerTask, [&](int64_t begin, int64_t end) {
    batch.evaluate(order, x, begin, end, out.data() + batch.block_of_group(begin) * width);
  });
  return out;
}

}  // namespace stark
