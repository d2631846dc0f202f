// Nested dissection: components, separators, minimum degree with halo at the leaves.
#include <stark/linalg/ordering.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <stark/base/error.h>
#include <stark/linalg/vertex_separator.h>

namespace stark {

namespace {

constexpr int32_t kLeafNodes = 120;         // pieces up to this size are ordered by minimum degree
constexpr double kThreadShare = 0.1;        // of the nodes: pieces up to this size are one task
constexpr double kUselessSeparator = 0.35;  // of the nodes: such a piece is better left to minimum degree
constexpr int32_t kDenseDegree = 64;        // least degree of a "dense" node,
constexpr double kDenseFactor =
    10.0;  // which also exceeds this multiple of the square root of the node count

/// Nodes that follow each other in the order: to be dissected, or in their final order.
struct Piece {
  std::vector<int32_t> nodes;
  bool is_ordered = false;
};

/// Takes pieces apart, one after the other: each thread has its own.
class NestedDissection {
 public:
  explicit NestedDissection(const AdjacencyGraph& graph) : graph_(graph) {
    local_.assign(graph.node_count(), -1);
  }

  /// Pieces that do not touch each other and last, if there is one, what separates them.
  std::vector<Piece> split(std::vector<int32_t> nodes);
  /// Appends the nodes in their final order.
  void order(Piece piece, std::vector<int32_t>& out);

 private:
  std::vector<Piece> components(const WeightedGraph& piece, std::span<const int32_t> nodes) const;
  Piece leaf(std::span<const int32_t> nodes);
  void extract(std::span<const int32_t> nodes, WeightedGraph& out_graph);

  const AdjacencyGraph& graph_;
  std::vector<int32_t> local_;  // number of a node in the piece at hand, -1 outside
};

// The piece with its outer neighbours as halo, which makes the degrees at its border true.
Piece NestedDissection::leaf(std::span<const int32_t> nodes) {
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
  for (int32_t& k : order) k = members[k];
  return {std::move(order), true};
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

// The connected components of a piece, if it has several.
std::vector<Piece> NestedDissection::components(const WeightedGraph& piece,
                                                std::span<const int32_t> nodes) const {
  std::vector<int32_t> component(nodes.size(), -1), queue;
  int32_t count = 0;
  for (size_t root = 0; root < nodes.size(); ++root) {
    if (component[root] >= 0) continue;
    queue.assign(1, static_cast<int32_t>(root));
    component[root] = count;
    for (size_t head = 0; head < queue.size(); ++head)
      for (int32_t k = piece.start[queue[head]]; k < piece.start[queue[head] + 1]; ++k) {
        const int32_t j = piece.neighbor[k];
        if (component[j] < 0) component[j] = count, queue.push_back(j);
      }
    ++count;
  }
  if (count < 2) return {};
  std::vector<Piece> members(count);
  for (size_t k = 0; k < nodes.size(); ++k) members[component[k]].nodes.push_back(nodes[k]);
  return members;
}

std::vector<Piece> NestedDissection::split(std::vector<int32_t> nodes) {
  if (nodes.empty()) return {};
  if (static_cast<int32_t>(nodes.size()) <= kLeafNodes) return {leaf(nodes)};
  WeightedGraph piece;
  extract(nodes, piece);
  if (std::vector<Piece> members = components(piece, nodes); !members.empty()) return members;
  std::vector<uint8_t> part;
  find_vertex_separator(piece, part);
  piece = {};
  std::vector<Piece> side(3);
  for (size_t k = 0; k < nodes.size(); ++k) side[part[k]].nodes.push_back(nodes[k]);
  const double count = static_cast<double>(nodes.size());
  if (side[0].nodes.empty() || side[1].nodes.empty() ||
      static_cast<double>(side[kSeparator].nodes.size()) > kUselessSeparator * count)
    return {leaf(nodes)};
  side[kSeparator].is_ordered = true;  // it becomes one dense front, where the order is free
  return side;
}

void NestedDissection::order(Piece piece, std::vector<int32_t>& out) {
  if (piece.is_ordered) {
    out.insert(out.end(), piece.nodes.begin(), piece.nodes.end());
    return;
  }
  for (Piece& part : split(std::move(piece.nodes))) order(std::move(part), out);
}

/// Takes the largest pieces apart until there is enough to do for several threads.
std::vector<Piece> split_for_threads(std::vector<int32_t> nodes, std::vector<NestedDissection>& dissections,
                                     ThreadPool& pool) {
  const auto large = static_cast<size_t>(kThreadShare * static_cast<double>(nodes.size()));
  const auto is_large = [&](const Piece& piece) { return !piece.is_ordered && piece.nodes.size() > large; };
  std::vector<Piece> pieces(1);
  pieces[0].nodes = std::move(nodes);
  while (std::ranges::any_of(pieces, is_large)) {
    std::vector<std::vector<Piece>> parts(pieces.size());
    pool.for_each_task(static_cast<int64_t>(pieces.size()), [&](int64_t k, int thread) {
      if (is_large(pieces[k]))
        parts[k] = dissections[thread].split(std::move(pieces[k].nodes));
      else
        parts[k].push_back(std::move(pieces[k]));
    });
    pieces.clear();
    for (auto& part : parts) std::ranges::move(part, std::back_inserter(pieces));
  }
  return pieces;
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

std::vector<int32_t> fill_reducing_order(const AdjacencyGraph& graph, ThreadPool& pool) {
  const int32_t n = graph.node_count();
  // Nodes that touch a large part of the system, such as a floor in contact with everything, go last: they
  // would only hide the structure of the rest.
  const double dense = std::max<double>(kDenseDegree, kDenseFactor * std::sqrt(static_cast<double>(n)));
  std::vector<int32_t> sparse_nodes, dense_nodes;
  for (int32_t i = 0; i < n; ++i) (graph.degree(i) > dense ? dense_nodes : sparse_nodes).push_back(i);
  std::vector<NestedDissection> dissections(pool.thread_count(), NestedDissection(graph));
  std::vector<Piece> pieces = split_for_threads(std::move(sparse_nodes), dissections, pool);
  std::vector<std::vector<int32_t>> orders(pieces.size());
  pool.for_each_task(static_cast<int64_t>(pieces.size()), [&](int64_t k, int thread) {
    dissections[thread].order(std::move(pieces[k]), orders[k]);
  });
  std::stable_sort(dense_nodes.begin(), dense_nodes.end(),
                   [&](int32_t a, int32_t b) { return graph.degree(a) < graph.degree(b); });
  orders.push_back(std::move(dense_nodes));
  std::vector<int32_t> order;
  order.reserve(n);
  for (const auto& part : orders) order.insert(order.end(), part.begin(), part.end());
  STARK_CHECK(static_cast<int32_t>(order.size()) == n);
  return order;
}

}  // namespace stark
