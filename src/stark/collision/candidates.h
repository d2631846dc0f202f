// The lists of primitive pairs that may touch, and the table of those that may at all. Pure data; the broad
// phase fills the lists, continuous detection and contact read them in every iteration.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <stark/collision/primitive_pairs.h>

namespace stark {

/// Pairs that share no vertex, each once: a list for each kind, sorted.
struct CandidateList {
  std::array<std::vector<PrimitivePair>, kPairKindCount> lists;

  std::vector<PrimitivePair>& operator[](PairKind kind) { return lists[static_cast<size_t>(kind)]; }
  const std::vector<PrimitivePair>& operator[](PairKind kind) const {
    return lists[static_cast<size_t>(kind)];
  }
  void clear();
  int64_t size() const;
  bool operator==(const CandidateList&) const = default;
};

/// Which groups may touch: a symmetric table that includes each group with itself. Single vertices may be
/// kept from a group, with every primitive that they are part of.
class PairFilter {
 public:
  PairFilter() = default;
  explicit PairFilter(int32_t group_count, bool allow_pairs = true, bool allow_self = true);

  void set(int32_t group_a, int32_t group_b, bool allowed);
  bool allowed(int32_t group_a, int32_t group_b) const { return table_[index(group_a, group_b)]; }
  int32_t group_count() const { return group_count_; }

  /// Keeps all primitives with this vertex from those of the group.
  void exclude(int32_t vertex, int32_t group);
  /// Keeps all primitives with this vertex from those with one of the others, sorted.
  void exclude_from(int32_t vertex, std::vector<int32_t> others);
  bool has_exclusions() const { return !excluded_.empty() || !excluded_from_.empty(); }
  bool excluded(int32_t vertex, int32_t group) const;
  /// Whether some vertex of one primitive is kept from the group of the other, or from a vertex of it.
  bool excluded(std::span<const int32_t> vertices_a, int32_t group_a, std::span<const int32_t> vertices_b,
                int32_t group_b) const;

  /// Keeps a point, and the edges without triangles that end at it, from those that end at another: parts of
  /// a rod that are so near along it that they are within the contact distance whatever its shape.
  void set_neighbours(int32_t vertex_a, int32_t vertex_b);
  bool has_neighbours() const { return !neighbours_.empty(); }
  bool are_neighbours(int32_t point, const Index2& edge) const;
  bool are_neighbours(const Index2& edge_a, const Index2& edge_b) const;

 private:
  static size_t index(int32_t a, int32_t b) {
    const size_t low = static_cast<size_t>(a < b ? a : b), high = static_cast<size_t>(a < b ? b : a);
    return high * (high + 1) / 2 + low;
  }

  int32_t group_count_ = 0;
  std::vector<bool> table_;
  std::vector<std::vector<int32_t>> excluded_;       ///< groups, by vertex; as long as needed
  std::vector<std::vector<int32_t>> excluded_from_;  ///< vertices, by vertex, sorted; as long as needed
  std::vector<std::vector<int32_t>> neighbours_;     ///< vertices, by vertex; as long as needed
};

}  // namespace stark
