// Candidate lists and the table of allowed pairs. See candidates.h.
#include <stark/collision/candidates.h>

#include <algorithm>
#include <string>

#include <stark/base/error.h>

namespace stark {

void CandidateList::clear() {
  for (std::vector<PrimitivePair>& list : lists) list.clear();
}

int64_t CandidateList::size() const {
  int64_t count = 0;
  for (const std::vector<PrimitivePair>& list : lists) count += static_cast<int64_t>(list.size());
  return count;
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

void PairFilter::exclude(int32_t vertex, int32_t group) {
  if (vertex < 0 || group < 0 || group >= group_count_) {
    throw InvalidArgument("PairFilter: vertex " + std::to_string(vertex) + " must be at least 0 and group " +
                          std::to_string(group) + " in [0, " + std::to_string(group_count_) + ")");
  }
  if (excluded_.size() <= static_cast<size_t>(vertex)) excluded_.resize(vertex + 1);
  if (!excluded(vertex, group)) excluded_[vertex].push_back(group);
}

void PairFilter::exclude_from(int32_t vertex, std::vector<int32_t> others) {
  if (vertex < 0)
    throw InvalidArgument("PairFilter: vertex " + std::to_string(vertex) + " must be at least 0");
  if (excluded_from_.size() <= static_cast<size_t>(vertex)) excluded_from_.resize(vertex + 1);
  excluded_from_[vertex] = std::move(others);
}

bool PairFilter::excluded(int32_t vertex, int32_t group) const {
  if (static_cast<size_t>(vertex) >= excluded_.size()) return false;
  const std::vector<int32_t>& groups = excluded_[vertex];
  return std::find(groups.begin(), groups.end(), group) != groups.end();
}

void PairFilter::set_neighbours(int32_t vertex_a, int32_t vertex_b) {
  if (vertex_a < 0 || vertex_b < 0) {
    throw InvalidArgument("PairFilter: neighbours " + std::to_string(vertex_a) + " and " +
                          std::to_string(vertex_b) + " must be at least 0");
  }
  const size_t count = static_cast<size_t>(std::max(vertex_a, vertex_b)) + 1;
  if (neighbours_.size() < count) neighbours_.resize(count);
  neighbours_[vertex_a].push_back(vertex_b);
  neighbours_[vertex_b].push_back(vertex_a);
}

bool PairFilter::are_neighbours(int32_t point, const Index2& edge) const {
  if (static_cast<size_t>(point) >= neighbours_.size()) return false;
  const std::vector<int32_t>& list = neighbours_[point];
  return std::any_of(list.begin(), list.end(), [&](int32_t v) { return v == edge[0] || v == edge[1]; });
}

bool PairFilter::are_neighbours(const Index2& edge_a, const Index2& edge_b) const {
  return are_neighbours(edge_a[0], edge_b) || are_neighbours(edge_a[1], edge_b);
}

bool PairFilter::excluded(std::span<const int32_t> vertices_a, int32_t group_a,
                          std::span<const int32_t> vertices_b, int32_t group_b) const {
  const auto some = [&](std::span<const int32_t> vertices, int32_t group) {
    return std::any_of(vertices.begin(), vertices.end(), [&](int32_t v) { return excluded(v, group); });
  };
  const auto some_from = [&](std::span<const int32_t> vertices, std::span<const int32_t> others) {
    return std::any_of(vertices.begin(), vertices.end(), [&](int32_t v) {
      return static_cast<size_t>(v) < excluded_from_.size() &&
             std::any_of(
                 others.begin(), others.end(),
                 [&](int32_t other) {
                   return std::binary_search(excluded_from_[v].begin(), excluded_from_[v].end(), other);
                 });
    });
  };
  return some(vertices_a, group_b) || some(vertices_b, group_a) ||
         (group_a == group_b && !excluded_from_.empty() &&
          (some_from(vertices_a, vertices_b) || some_from(vertices_b, vertices_a)));
}

}  // namespace stark
