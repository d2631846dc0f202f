// Lists that threads make together: each task its part, joined in the order of the tasks.
#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <utility>
#include <vector>

#include <stark/base/thread_pool.h>

namespace stark {

/// Calls body(begin, end, out) on consecutive ranges of [0, count) of `grain` items, at least once, on all
/// threads. Returns what they append to `out`, in the order of the ranges.
template <typename T, typename Body>
std::vector<T> collect_ranges(ThreadPool& pool, int64_t count, int64_t grain, Body&& body) {
  std::vector<std::vector<T>> parts(std::max<int64_t>((count + grain - 1) / grain, 1));
  pool.for_each_task(std::ssize(parts), [&](int64_t task, int) {
    body(task * grain, std::min(task * grain + grain, count), parts[task]);
  });
  size_t total = 0;
  for (const std::vector<T>& part : parts) total += part.size();
  std::vector<T> all = std::move(parts.front());
  all.reserve(total);
  for (size_t k = 1; k < parts.size(); ++k)
    all.insert(all.end(), std::make_move_iterator(parts[k].begin()), std::make_move_iterator(parts[k].end()));
  return all;
}

}  // namespace stark
