// Sorting by whole numbers that are about as many as the items, such as vertices: by counting.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace stark {

/// Sorts items by number(item), an integer, and items of one number by less(a, b). Takes time in proportion
/// to the items, unless their numbers lie far apart or many are the same.
template <typename T, typename Number, typename Less>
void bucket_sort(std::vector<T>& items, Number&& number, Less&& less) {
  constexpr int64_t kMostBuckets = 8;  // for each item
  if (items.empty()) return;
  int64_t low = number(items.front()), high = low;
  for (const T& item : items) {
    low = std::min<int64_t>(low, number(item));
    high = std::max<int64_t>(high, number(item));
  }
  if (high - low > kMostBuckets * static_cast<int64_t>(items.size())) {
    std::sort(items.begin(), items.end(), [&](const T& a, const T& b) {
      return number(a) != number(b) ? number(a) < number(b) : less(a, b);
    });
    return;
  }
  std::vector<int64_t> next(static_cast<size_t>(high - low) + 2, 0);  // place of each number's next item
  for (const T& item : items) ++next[number(item) - low + 1];
  for (size_t bucket = 1; bucket < next.size(); ++bucket) next[bucket] += next[bucket - 1];
  std::vector<T> sorted(items.size());
  for (const T& item : items) sorted[next[number(item) - low]++] = item;
  int64_t begin = 0;
  for (size_t bucket = 0; bucket + 1 < next.size(); ++bucket) {  // `next` now is the end of each bucket
    std::sort(sorted.begin() + begin, sorted.begin() + next[bucket], less);
    begin = next[bucket];
  }
  items.swap(sorted);
}

}  // namespace stark
