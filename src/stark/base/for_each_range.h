// Ranges of items on a pool, or all at once where there is none.
#pragma once

#include <cstdint>

#include <stark/base/thread_pool.h>

namespace stark {

/// Calls body(begin, end) on consecutive ranges of [0, count) of `grain` items on a pool. Without one, or
/// from within its tasks, pool is null, and all is one range.
template <typename Body>
void for_each_range(ThreadPool* pool, int64_t count, int64_t grain, Body&& body) {
  if (pool != nullptr)
    pool->for_each_range(count, grain, body);
  else
    body(int64_t{0}, count);
}

}  // namespace stark
