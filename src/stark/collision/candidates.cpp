// Candidate lists and the table of allowed pairs. See candidates.h.
#include <stark/collision/candidates.h>

#include <string>

#include <stark/base/error.h>

namespace stark {

void CandidateList::clear() {
  point_triangle.clear();
  edge_edge.clear();
  point_edge.clear();
  point_point.clear();
}

int64_t CandidateList::size() const {
  return static_cast<int64_t>(point_triangle.size() + edge_edge.size() + point_edge.size() +
                              point_point.size());
}

PairFilter::PairFilter(int32_t group_count, bool allow_pairs, bool allow_self) : group_count_(group_count) {
  if (group_count < 0) {
    throw InvalidArgument("PairFilter: group_count is " + std::to_string(group_count) +
                          "; it must be at least 0");
  }
  table_.assign(static_cast<size_t>(group_count) * (static_cast<size_t>(group_count) + 1) / 2, allow_pairs);
  for (int32_t group = 0; group < group_count; ++group) table_[index(group, group)] = allow_self;
}

void PairFilter::set(int32_t group_a, int32_t group_b, bool allowed) {
  if (group_a < 0 || group_b < 0 || group_a >= group_count_ || group_b >= group_count_) {
    throw InvalidArgument("PairFilter: groups " + std::to_string(group_a) + " and " +
                          std::to_string(group_b) + " must be in [0, " + std::to_string(group_count_) + ")");
  }
  table_[index(group_a, group_b)] = allowed;
}

}  // namespace stark
