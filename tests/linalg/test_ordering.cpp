// Nested dissection: permutations, and fill on meshes.
#include <stark/linalg/ordering.h>

#include <doctest/doctest.h>
#include <stark/linalg/elimination.h>

#include "linalg/systems.h"

using namespace stark;

TEST_CASE("ordering: nested dissection gives permutations, the same on any number of threads") {
  ThreadPool alone(1), several(3);
  for (const test::GraphCase& c : test::ordering_cases()) {
    CAPTURE(c.name);
    const AdjacencyGraph graph =
        AdjacencyGraph::from_pattern(BlockPattern::from_pairs(c.block_count, c.pairs));
    const std::vector<int32_t> order = fill_reducing_order(graph, alone);
    CHECK(test::is_permutation_of_all(order, c.block_count));
    CHECK(order == fill_reducing_order(graph, several));
  }
}

TEST_CASE("ordering: fill on meshes stays near that of METIS 5.1") {
  // Flops of METIS_NodeND on the same graphs, 1.15 times which is allowed.
  const auto flops_of = [](int32_t n, const test::Pairs& pairs) {
    const BlockPattern pattern = BlockPattern::from_pairs(n, pairs);
    SymbolicFactorization symbolic;
    AssemblyTree tree;
    ThreadPool pool(1);
    symbolic.analyze(pattern, fill_reducing_order(AdjacencyGraph::from_pattern(pattern), pool), 12, tree);
    return tree.flops;
  };
  CHECK(flops_of(3600, test::cloth_pairs(60)) < 1.15 * 3.83e8);
  int32_t count = 0;
  const test::Pairs solid = test::solid_pairs(10, count);
  CHECK(flops_of(count, solid) < 1.15 * 2.51e8);
}
