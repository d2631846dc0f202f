// Small balanced vertex separators by the multilevel method: heavy-edge matching, greedy growing on the
// coarsest graph, Fiduccia-Mattheyses refinement of the separator on every level (Hendrickson and Rothberg
// 1998; Karypis and Kumar 1998). Phase: ordering of the linear solver.
#pragma once

#include <cstdint>
#include <vector>

namespace stark {

/// Undirected graph with integer weights; every edge is listed at both ends.
struct WeightedGraph {
  std::vector<int32_t> start;  // [node_count + 1]
  std::vector<int32_t> neighbor;
  std::vector<int32_t> edge_weight;
  std::vector<int32_t> node_weight;

  int32_t node_count() const { return static_cast<int32_t>(start.size()) - 1; }
};

inline constexpr uint8_t kSeparator = 2;

/// out_part[i] is 0 or 1, the side of node i, or kSeparator; no edge joins the sides. Deterministic. A side
/// may be empty for graphs that cannot be cut to advantage.
void find_vertex_separator(const WeightedGraph& graph, std::vector<uint8_t>& out_part);

}  // namespace stark
