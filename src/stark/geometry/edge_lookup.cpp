#include <stark/geometry/edge_lookup.h>

#include <algorithm>
#include <tuple>

#include <stark/base/bucket_sort.h>

namespace stark {

EdgeLookup::EdgeLookup(std::span<const Index2> edges) {
  entries_.reserve(edges.size());
  for (size_t e = 0; e < edges.size(); ++e) {
    const auto [low, high] = std::minmax(edges[e][0], edges[e][1]);
    entries_.push_back({low, high, static_cast<int32_t>(e)});
  }
  bucket_sort(
      entries_, [](const Entry& e) { return e.low; },
      [](const Entry& a, const Entry& b) { return std::tie(a.high, a.edge) < std::tie(b.high, b.edge); });
  start_.assign(entries_.empty() ? 1 : static_cast<size_t>(entries_.back().low) + 2, 0);
  for (const Entry& e : entries_) ++start_[e.low + 1];
  for (size_t v = 1; v < start_.size(); ++v) start_[v] += start_[v - 1];
}

int32_t EdgeLookup::find(int32_t a, int32_t b) const {
  const auto [low, high] = std::minmax(a, b);
  if (static_cast<size_t>(low) + 1 >= start_.size()) return -1;
  const auto end = entries_.begin() + start_[low + 1];
  const auto found = std::lower_bound(entries_.begin() + start_[low], end, high,
                                      [](const Entry& e, int32_t v) { return e.high < v; });
  return found != end && found->high == high ? found->edge : -1;
}

}  // namespace stark
