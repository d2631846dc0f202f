// Fill-reducing orderings of symmetric graphs: nested dissection (George 1973; Karypis and Kumar 1998 for the
// multilevel form) down to small pieces, which are ordered by approximate minimum degree (Amestoy, Davis and
// Duff 1996) with their surroundings as a halo (Pellegrini, Roman and Amestoy 2000). Phase: first linear
// solve, and when contacts have spoilt the last ordering.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <stark/base/thread_pool.h>
#include <stark/linalg/block_matrix.h>

namespace stark {

/// Adjacency lists of an undirected graph without loops; every edge is listed at both ends.
struct AdjacencyGraph {
  std::vector<int32_t> start;  // [node_count + 1]
  std::vector<int32_t> neighbor;

  int32_t node_count() const { return static_cast<int32_t>(start.size()) - 1; }
  int32_t degree(int32_t i) const { return start[i + 1] - start[i]; }
  std::span<const int32_t> neighbors(int32_t i) const {
    return {neighbor.data() + start[i], static_cast<size_t>(degree(i))};
  }
  static AdjacencyGraph from_pattern(const BlockPattern& pattern);
};

/// Order of all nodes by nested dissection with minimum degree at the leaves: out[k] is the node eliminated
/// k-th. The same on any number of threads. Disconnected graphs are welcome.
std::vector<int32_t> fill_reducing_order(const AdjacencyGraph& graph, ThreadPool& pool);

/// Approximate minimum degree on a whole graph or, with `halo` (one flag per node, may be empty), on its
/// other nodes: halo nodes count as neighbours but are never eliminated. Appends to `out_order`.
void minimum_degree_order(const AdjacencyGraph& graph, std::span<const uint8_t> halo,
                          std::vector<int32_t>& out_order);

}  // namespace stark
