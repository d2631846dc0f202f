// Approximate minimum degree: permutations, halo, and known optima.
#include <stark/linalg/ordering.h>

#include <set>

#include <doctest/doctest.h>
#include <stark/linalg/elimination.h>

#include "linalg/systems.h"

using namespace stark;

TEST_CASE("minimum degree: permutations of every graph, twice the same") {
  for (const test::GraphCase& c : test::ordering_cases()) {
    CAPTURE(c.name);
    const AdjacencyGraph graph =
        AdjacencyGraph::from_pattern(BlockPattern::from_pairs(c.block_count, c.pairs));
    std::vector<int32_t> order, again;
    minimum_degree_order(graph, {}, order);
    minimum_degree_order(graph, {}, again);
    CHECK(test::is_permutation_of_all(order, c.block_count));
    CHECK(order == again);
  }
}

TEST_CASE("minimum degree: trees are eliminated without fill") {
  // A binary tree, a star and a path: leaves first leaves no fill, so the factor has one block per edge.
  test::Pairs tree, star, path;
  for (int i = 1; i < 511; ++i) tree.emplace_back((i - 1) / 2, i);
  for (int i = 1; i < 511; ++i) star.emplace_back(255, i == 255 ? 0 : i);
  for (int i = 1; i < 511; ++i) path.emplace_back(i * 37 % 511, (i - 1) * 37 % 511);
  for (const test::Pairs& pairs : {tree, star, path}) {
    const BlockPattern pattern = BlockPattern::from_pairs(511, pairs);
    std::vector<int32_t> order;
    minimum_degree_order(AdjacencyGraph::from_pattern(pattern), {}, order);
    SymbolicFactorization symbolic;
    AssemblyTree assembly;
    symbolic.analyze(pattern, order, 12, assembly);
    // Columns with one block below the diagonal block have 6, 5 and 4 entries, the last one 3, 2 and 1.
    CHECK(assembly.flops == doctest::Approx(510 * (36.0 + 25.0 + 16.0) + 9.0 + 4.0 + 1.0));
  }
}

TEST_CASE("minimum degree: halo nodes are not eliminated") {
  const AdjacencyGraph graph =
      AdjacencyGraph::from_pattern(BlockPattern::from_pairs(400, test::cloth_pairs(20)));
  std::vector<uint8_t> halo(400, 0);
  for (int i = 0; i < 400; i += 7) halo[i] = 1;
  std::vector<int32_t> order;
  minimum_degree_order(graph, halo, order);
  CHECK(order.size() == 400 - 58);
  for (int32_t i : order) CHECK(halo[i] == 0);
  CHECK(std::set<int32_t>(order.begin(), order.end()).size() == order.size());
}
