// Matching and contraction of graphs.
#include <stark/linalg/graph_coarsening.h>

#include <map>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <stark/linalg/ordering.h>

#include "linalg/systems.h"

using namespace stark;

TEST_CASE("graph coarsening: pairs are mutual and light, contraction keeps the weights between groups") {
  for (const test::GraphCase& c : test::ordering_cases()) {
    CAPTURE(c.name);
    const AdjacencyGraph graph =
        AdjacencyGraph::from_pattern(BlockPattern::from_pairs(c.block_count, c.pairs));
    WeightedGraph fine{graph.start, graph.neighbor, {}, {}};
    fine.edge_weight.assign(graph.neighbor.size(), 1);
    for (int32_t i = 0; i < c.block_count; ++i) fine.node_weight.push_back(1 + i % 3);
    PseudoRandom random;
    for (int level = 0; level < 3; ++level) {
      const int32_t limit = 8 + 4 * level;
      std::vector<int32_t> match, coarse_of;
      match_heavy_edges(fine, limit, random, match);
      WeightedGraph coarse;
      contract(fine, match, coarse, coarse_of);
      std::vector<int32_t> weight(coarse.node_count(), 0);
      std::map<std::pair<int32_t, int32_t>, int32_t> expected, got;
      for (int32_t i = 0; i < fine.node_count(); ++i) {
        REQUIRE(match[match[i]] == i);
        REQUIRE(coarse_of[i] == coarse_of[match[i]]);
        if (match[i] != i) REQUIRE(fine.node_weight[i] + fine.node_weight[match[i]] <= limit);
        weight[coarse_of[i]] += fine.node_weight[i];
        for (int32_t k = fine.start[i]; k < fine.start[i + 1]; ++k) {
          const int32_t a = coarse_of[i], b = coarse_of[fine.neighbor[k]];
          if (a != b) expected[{a, b}] += fine.edge_weight[k];
        }
      }
      CHECK(weight == coarse.node_weight);
      for (int32_t i = 0; i < coarse.node_count(); ++i)
        for (int32_t k = coarse.start[i]; k < coarse.start[i + 1]; ++k) {
          REQUIRE_FALSE(got.contains({i, coarse.neighbor[k]}));
          got[{i, coarse.neighbor[k]}] = coarse.edge_weight[k];
        }
      CHECK(got == expected);
      fine = std::move(coarse);
    }
  }
}

TEST_CASE("graph coarsening: a star shrinks by half although its leaves have one neighbour") {
  test::Pairs star;
  for (int i = 1; i < 1001; ++i) star.emplace_back(0, i);
  const AdjacencyGraph graph = AdjacencyGraph::from_pattern(BlockPattern::from_pairs(1001, star));
  WeightedGraph fine{graph.start, graph.neighbor, {}, {}};
  fine.edge_weight.assign(graph.neighbor.size(), 1);
  fine.node_weight.assign(1001, 1);
  PseudoRandom random;
  std::vector<int32_t> match, coarse_of;
  match_heavy_edges(fine, 4, random, match);
  WeightedGraph coarse;
  contract(fine, match, coarse, coarse_of);
  CHECK(coarse.node_count() <= 502);
}
