// Heavy-edge matching and contraction.
#include <stark/linalg/graph_coarsening.h>

#include <algorithm>
#include <numeric>

namespace stark {

void match_heavy_edges(const WeightedGraph& graph, int32_t weight_limit, PseudoRandom& random,
                       std::vector<int32_t>& match) {
  const int32_t n = graph.node_count();
  // Nodes with few neighbours choose first, in random order among equals, as they have the least choice.
  std::vector<int32_t> visit(n), order(n), bucket;
  std::iota(visit.begin(), visit.end(), 0);
  for (int32_t i = n - 1; i > 0; --i) std::swap(visit[i], visit[random.below(i + 1)]);
  const int32_t classes = 64;
  const auto class_of = [&](int32_t i) { return std::min(graph.start[i + 1] - graph.start[i], classes - 1); };
  bucket.assign(classes + 1, 0);
  for (int32_t i : visit) ++bucket[class_of(i) + 1];
  for (int32_t c = 0; c < classes; ++c) bucket[c + 1] += bucket[c];
  for (int32_t i : visit) order[bucket[class_of(i)]++] = i;
  match.assign(n, -1);
  for (const int32_t i : order) {
    if (match[i] >= 0) continue;
    int32_t best = i, best_weight = 0;
    for (int32_t k = graph.start[i]; k < graph.start[i + 1]; ++k) {
      const int32_t j = graph.neighbor[k];
      if (match[j] >= 0 || graph.node_weight[i] + graph.node_weight[j] > weight_limit) continue;
      if (graph.edge_weight[k] > best_weight) best = j, best_weight = graph.edge_weight[k];
    }
    match[i] = best;
    match[best] = i;
  }
  // Nodes left alone, such as the leaves of a star, pair up with another one at the same neighbour.
  for (int32_t center = 0; center < n; ++center) {
    int32_t waiting = -1;
    for (int32_t k = graph.start[center]; k < graph.start[center + 1]; ++k) {
      const int32_t j = graph.neighbor[k];
      if (match[j] != j) continue;
      if (waiting < 0) {
        waiting = j;
      } else if (graph.node_weight[waiting] + graph.node_weight[j] <= weight_limit) {
        match[waiting] = j;
        match[j] = waiting;
        waiting = -1;
      }
    }
  }
}

void contract(const WeightedGraph& fine, const std::vector<int32_t>& match, WeightedGraph& coarse,
              std::vector<int32_t>& coarse_of) {
  const int32_t n = fine.node_count();
  coarse_of.assign(n, -1);
  int32_t count = 0;
  for (int32_t i = 0; i < n; ++i)
    if (match[i] >= i) coarse_of[i] = coarse_of[match[i]] = count++;
  coarse.start.assign(1, 0);
  coarse.start.reserve(static_cast<size_t>(count) + 1);
  coarse.neighbor.reserve(fine.neighbor.size());
  coarse.edge_weight.reserve(fine.neighbor.size());
  coarse.node_weight.reserve(count);
  std::vector<int32_t> place(count, -1);  // of a neighbour in the current list
  for (int32_t i = 0; i < n; ++i) {
    if (match[i] < i) continue;
    const int32_t self = coarse_of[i];
    const auto begin = static_cast<int32_t>(coarse.neighbor.size());
    const auto add_edges_of = [&](int32_t node) {
      for (int32_t k = fine.start[node]; k < fine.start[node + 1]; ++k) {
        const int32_t c = coarse_of[fine.neighbor[k]];
        if (c == self) continue;
        if (place[c] >= begin) {
          coarse.edge_weight[place[c]] += fine.edge_weight[k];
        } else {
          place[c] = static_cast<int32_t>(coarse.neighbor.size());
          coarse.neighbor.push_back(c);
          coarse.edge_weight.push_back(fine.edge_weight[k]);
        }
      }
    };
    add_edges_of(i);
    if (match[i] != i) add_edges_of(match[i]);
    coarse.node_weight.push_back(fine.node_weight[i] + (match[i] != i ? fine.node_weight[match[i]] : 0));
    coarse.start.push_back(static_cast<int32_t>(coarse.neighbor.size()));
  }
}

}  // namespace stark
