// See point_scatter.h.
#include <stark/mechanics/point_scatter.h>

#include <algorithm>
#include <atomic>

#include <stark/mechanics/congruence.h>

namespace stark {

using symbolic::kLanes;

namespace {

constexpr int64_t kFewest = 1024;  ///< elements, below which threads wait longer than they work
constexpr int64_t kElementsPerTask = 1024;
constexpr size_t kSamples = 1024;  ///< nodes by which rows are cut

}  // namespace

bool PointScatter::take(const PotentialBatch& batch, const KinematicMap& map, ThreadPool& pool) {
  if (pool.thread_count() < 2 || batch.size() < kFewest) return false;
  const int points = batch.point_count();
  blocks_.resize(batch.size() * points);
  std::atomic<bool> only_points{true};
  pool.for_each_range(batch.size(), kElementsPerTask, [&](int64_t begin, int64_t end) {
    const auto stencils = batch.stencils();
    for (int64_t k = begin * points; k < end * points; ++k) {
      const int32_t site = stencils[k];
      const bool is_prescribed = map.is_prescribed(site);
      if (!is_prescribed && !map.is_point(site)) {
        only_points.store(false);
        return;
      }
      blocks_[k] = is_prescribed ? kNoBlock : map.point_block(site);
    }
  });
  if (only_points.load()) cut_rows(map.layout().block_count, pool.thread_count());
  return only_points.load();
}

void PointScatter::cut_rows(int32_t row_count, int ranges) {
  std::vector<int32_t> sample;
  for (size_t k = 0; k < blocks_.size(); k += blocks_.size() / kSamples + 1)
    if (blocks_[k] != kNoBlock) sample.push_back(blocks_[k]);
  std::ranges::sort(sample);
  cuts_.assign(1, 0);
  for (int k = 1; k < ranges && !sample.empty(); ++k) cuts_.push_back(sample[k * sample.size() / ranges]);
  cuts_.push_back(row_count);
}

void PointScatter::add(const PotentialBatch& batch, const double* lanes, ThreadPool& pool,
                       std::span<double> gradient, BlockMatrix& hessian) const {
  const int points = batch.point_count();
  const int64_t outputs = batch.potential().kernel().output_count(symbolic::Order::Hessian);
  pool.for_each_task(std::ssize(cuts_) - 1, [&](int64_t task, int) {
    const RowRange rows{cuts_[task], cuts_[task + 1]};
    for (int64_t e = 0; e < batch.size(); ++e) {
      const std::span<const int32_t> blocks(blocks_.data() + e * points, points);
      if (batch.rests(e / kLanes) || std::ranges::none_of(blocks, [&](int32_t b) { return rows.has(b); }))
        continue;
      const ElementView element(lanes + e / kLanes * outputs * kLanes, 3 * points,
                                static_cast<int>(e % kLanes));
      add_point_element(element, blocks, {}, rows, gradient, hessian);
    }
  });
}

}  // namespace stark
