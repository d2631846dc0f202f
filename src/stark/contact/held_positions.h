// The positions that a result is of, to tell whether it still is: a copy, compared bit for bit, on several
// threads where there are many (step phases 4b and 4h).
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include <stark/base/math.h>
#include <stark/base/thread_pool.h>

namespace stark {

class HeldPositions {
 public:
  void hold(std::span<const Vec3> x, ThreadPool& pool) {
    held_.resize(x.size());
    pool.for_each_range(std::ssize(x), kPerTask, [&](int64_t begin, int64_t end) {
      std::ranges::copy(x.subspan(begin, end - begin), held_.begin() + begin);
    });
  }

  bool are(std::span<const Vec3> x, ThreadPool& pool) const {
    if (x.size() != held_.size()) return false;
    std::atomic<bool> same{true};
    pool.for_each_range(std::ssize(x), kPerTask, [&](int64_t begin, int64_t end) {
      if (!same.load(std::memory_order_relaxed)) return;
      if (std::memcmp(x.data() + begin, held_.data() + begin, (end - begin) * sizeof(Vec3)) != 0)
        same.store(false, std::memory_order_relaxed);
    });
    return same.load();
  }

  std::span<const Vec3> get() const { return held_; }
  void swap(HeldPositions& other) { held_.swap(other.held_); }

 private:
  static constexpr int64_t kPerTask = 16384;

  std::vector<Vec3> held_;
};

}  // namespace stark
