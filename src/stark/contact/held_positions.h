// The positions that a result is of, to tell whether it still is: a copy, compared bit for bit, on several
// threads where there are many (step phases 4b and 4h).
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include <stark/base/thread_pool.h>
#include <stark/mechanics/site_positions.h>

namespace stark {

class HeldPositions {
 public:
  void hold(const SitePositions& x, ThreadPool& pool) {
    held_.resize(x.all.size());
    for_each_piece(x, pool, [&](int64_t begin, int64_t count) {
      std::ranges::copy(x.all.subspan(begin, count), held_.begin() + begin);
    });
    still_ = x.still;
  }

  bool are(const SitePositions& x, ThreadPool& pool) const {
    if (x.all.size() != held_.size()) return false;
    std::atomic<bool> same{true};
    for_each_piece(x, pool, [&](int64_t begin, int64_t count) {
      if (!same.load(std::memory_order_relaxed)) return;
      if (std::memcmp(x.all.data() + begin, held_.data() + begin, count * sizeof(Vec3)) != 0)
        same.store(false, std::memory_order_relaxed);
    });
    return same.load();
  }

  std::span<const Vec3> get() const { return held_; }
  void swap(HeldPositions& other) {
    held_.swap(other.held_);
    std::swap(still_, other.still_);
  }

 private:
  static constexpr int64_t kPerTask = 16384;

  /// Calls body(begin, count) for what may differ from what is held.
  template <typename Body>
  void for_each_piece(const SitePositions& x, ThreadPool& pool, Body&& body) const {
    const SiteRange all{0, static_cast<int32_t>(x.all.size())};
    const bool is_known = x.still != 0 && x.still == still_;
    for (const SiteRange& range : is_known ? x.moving : std::span(&all, 1))
      pool.for_each_range(range.end - range.begin, kPerTask,
                          [&](int64_t begin, int64_t end) { body(range.begin + begin, end - begin); });
  }

  std::vector<Vec3> held_;
  uint64_t still_ = 0;  ///< see SitePositions
};

}  // namespace stark
