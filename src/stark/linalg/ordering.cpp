// Nested dissection: components, separators, minimum degree with halo at the leaves.
#include <stark/linalg/ordering.h>

#include <algorithm>
#include <cmath>

#include <stark/base/error.h>
#include <stark/linalg/vertex_separator.h>

namespace stark {

namespace {

constexpr int32_t kLeafNodes = 120;         // pieces up to this size are ordered by minimum degree
constexpr double kUselessSeparator = 0.35;  // of the nodes: such a piece is better left to minimum degree
constexpr int32_t kDenseDegree = 64;        // least degree of a "dense" node,
constexpr double kDenseFactor =
    10.0;  // which also exceeds this multiple of the square root of the node count

class NestedDissection {
 public:
  explicit NestedDissection(const AdjacencyGraph& graph) : graph_(graph) {
    local_.assign(graph.node_count(), -1);
  }

  std::vector<int32_t> run();

 private:
  void dissect(std::vector<int32_t> nodes);
  void order_leaf(std::span<const int32_t> nodes);
  void extract(std::span<const int32_t> nodes, WeightedGraph& out_graph);

  const AdjacencyGraph& graph_;
  std::vector<int32_t> local_;  // number of a node in the piece at hand, -1 outside
  std::vector<int32_t> order_;
};

std::vector<int32_t> NestedDissection::run() {
  const int32_t n = graph_.node_count();
  order_.reserve(n);
  // Nodes that touch a large part of the system, such as a floor in contact with everything, go last: they
  // would only hide the structure of the rest.
  const double dense = std::max<double>(kDenseDegree, kDenseFactor * std::sqrt(static_cast<double>(n)));
  std::vector<int32_t> sparse_nodes, dense_nodes;
  for (int32_t i = 0; i < n; ++i) (graph_.degree(i) > dense ? dense_nodes : sparse_nodes).push_back(i);
  dissect(std::move(sparse_nodes));
  std::stable_sort(dense_nodes.begin(), dense_nodes.end(),
                   [&](int32_t a, int32_t b) { return graph_.degree(a) < graph_.degree(b); });
  order_.insert(order_.end(), dense_nodes.begin(), dense_nodes.end());
  STARK_CHECK(static_cast<int32_t>(order_.size()) == n);
  return std::move(order_);
}

// The piece with its outer neighbours as halo, which makes the degrees at its border true.
void NestedDissection::order_leaf(std::span<const int32_t> nodes) {
  AdjacencyGraph leaf;
  std::vector<int32_t> members(nodes.begin(), nodes.end());
  for (size_t k = 0; k < members.size(); ++k) local_[members[k]] = static_cast<int32_t>(k);
  const auto inner = static_cast<int32_t>(nodes.size());
  leaf.start.assign(1, 0);
  std::vector<std::pair<int32_t, int32_t>> halo_edges;  // halo node, inner node
  for (int32_t k = 0; k < inner; ++k) {
    for (const int32_t j : graph_.neighbors(members[k])) {
      if (local_[j] < 0) {
        local_[j] = static_cast<int32_t>(members.size());
        members.push_back(j);
      }
      leaf.neighbor.push_back(local_[j]);
      if (local_[j] >= inner) halo_edges.emplace_back(local_[j], k);
    }
    leaf.start.push_back(static_cast<int32_t>(leaf.neighbor.size()));
  }
  std::sort(halo_edges.begin(), halo_edges.end());
  for (size_t e = 0; e < halo_edges.size(); ++e) {
    leaf.neighbor.push_back(halo_edges[e].second);
    if (e + 1 == halo_edges.size() || halo_edges[e + 1].first != halo_edges[e].first)
      leaf.start.push_back(static_cast<int32_t>(leaf.neighbor.size()));
  }
  for (const int32_t i : members) local_[i] = -1;
  std::vector<uint8_t> halo(members.size(), 1);
  std::fill(halo.begin(), halo.begin() + inner, uint8_t{0});
  std::vector<int32_t> order;
  minimum_degree_order(leaf, halo, order);
  for (const int32_t k : order) order_.push_back(members[k]);
}

void NestedDissection::extract(std::span<const int32_t> nodes, WeightedGraph& out_graph) {
  for (size_t k = 0; k < nodes.size(); ++k) local_[nodes[k]] = static_cast<int32_t>(k);
  out_graph.start.assign(1, 0);
  for (const int32_t i : nodes) {
    for (const int32_t j : graph_.neighbors(i))
      if (local_[j] >= 0) out_graph.neighbor.push_back(local_[j]);
    out_graph.start.push_back(static_cast<int32_t>(out_graph.neighbor.size()));
  }
  out_graph.edge_weight.assign(out_graph.neighbor.size(), 1);
  out_graph.node_weight.assign(nodes.size(), 1);
  for (const int32_t i : nodes) local_[i] = -1;
}

void NestedDissection::dissect(std::vector<int32_t> nodes) {
  if (nodes.empty()) return;
  if (static_cast<int32_t>(nodes.size()) <= kLeafNodes) return order_leaf(nodes);
  WeightedGraph piece;
  extract(nodes, piece);
  // Components are independent.
  std::vector<int32_t> component(nodes.size(), -1), queue;
  int32_t components = 0;
  for (size_t root = 0; root < nodes.size(); ++root) {
    if (component[root] >= 0) continue;
    queue.assign(1, static_cast<int32_t>(root));
    component[root] = components;
    for (size_t head = 0; head < queue.size(); ++head)
      for (int32_t k = piece.start[queue[head]]; k < piece.start[queue[head] + 1]; ++k) {
        const int32_t j = piece.neighbor[k];
        if (component[j] < 0) component[j] = components, queue.push_back(j);
      }
    ++components;
  }
  if (components > 1) {
    std::vector<std::vector<int32_t>> members(components);
    for (size_t k = 0; k < nodes.size(); ++k) members[component[k]].push_back(nodes[k]);
    for (std::vector<int32_t>& member : members) dissect(std::move(member));
    return;
  }
  std::vector<uint8_t> part;
  find_vertex_separator(piece, part);
  piece = {};
  std::vector<int32_t> side[3];
  for (size_t k = 0; k < nodes.size(); ++k) side[part[k]].push_back(nodes[k]);
  const double count = static_cast<double>(nodes.size());
  if (side[0].empty() || side[1].empty() ||
      static_cast<double>(side[kSeparator].size()) > kUselessSeparator * count)
    return order_leaf(nodes);
  nodes = {};
  dissect(std::move(side[0]));
  dissect(std::move(side[1]));
  // The separator becomes one dense front, where the order is free.
  order_.insert(order_.end(), side[kSeparator].begin(), side[kSeparator].end());
}

}  // namespace

AdjacencyGraph AdjacencyGraph::from_pattern(const BlockPattern& pattern) {
  AdjacencyGraph graph;
  const int32_t n = pattern.block_count;
  graph.start.assign(static_cast<size_t>(n) + 1, 0);
  for (int32_t i = 0; i < n; ++i)
    for (int64_t k = pattern.row_start[i] + 1; k < pattern.row_start[i + 1]; ++k) {
      ++graph.start[i + 1];
      ++graph.start[pattern.column[k] + 1];
    }
  for (int32_t i = 0; i < n; ++i) graph.start[i + 1] += graph.start[i];
  graph.neighbor.resize(graph.start[n]);
  std::vector<int32_t> next(graph.start.begin(), graph.start.end() - 1);
  for (int32_t i = 0; i < n; ++i)
    for (int64_t k = pattern.row_start[i] + 1; k < pattern.row_start[i + 1]; ++k) {
      const int32_t j = pattern.column[k];
      graph.neighbor[next[i]++] = j;
      graph.neighbor[next[j]++] = i;
    }
  return graph;
}

std::vector<int32_t> fill_reducing_order(const AdjacencyGraph& graph) {
  return NestedDissection(graph).run();
}

}  // namespace stark
