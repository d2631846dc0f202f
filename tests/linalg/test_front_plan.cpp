// Memory plan of the fronts: update matrices that are alive at the same time do not overlap.
#include <stark/linalg/front_plan.h>

#include <algorithm>

#include <doctest/doctest.h>
#include <stark/linalg/ordering.h>

#include "linalg/systems.h"

namespace {

using namespace stark;

int64_t update_size(const AssemblyTree& tree, int32_t s, int strip) {
  const int64_t strips = (3 * tree.row_count(s) + strip - 1) / strip;
  return strip * strip * strips * (strips + 1) / 2;
}

}  // namespace

TEST_CASE("front plan: every supernode once, live update matrices disjoint and inside their arena") {
  ThreadPool pool(1);
  std::vector<test::GraphCase> cases = test::ordering_cases();
  int32_t count = 0;
  const test::Pairs solid = test::solid_pairs(7, count);
  cases.push_back({"large solid", count, solid});
  cases.push_back({"large cloth", 2500, test::cloth_pairs(50)});
  for (const test::GraphCase& c : cases) {
    CAPTURE(c.name);
    const int strip = 12;
    const BlockPattern pattern = BlockPattern::from_pairs(c.block_count, c.pairs);
    SymbolicFactorization symbolic;
    AssemblyTree tree;
    symbolic.analyze(pattern, fill_reducing_order(AdjacencyGraph::from_pattern(pattern), pool), strip, tree);
    FrontPlan plan;
    plan.build(tree, strip, 4);
    std::vector<int32_t> sequence;
    for (const FrontPlan::Subtree& subtree : plan.subtrees)
      for (int32_t s = subtree.begin; s < subtree.end; ++s) sequence.push_back(s);
    sequence.insert(sequence.end(), plan.top.begin(), plan.top.end());
    REQUIRE(test::is_permutation_of_all(sequence, tree.supernode_count()));
    std::vector<int32_t> alive;
    for (const int32_t s : sequence) {
      const bool shared = plan.update_shared[s] != 0;
      const int64_t begin = plan.update_offset[s], end = begin + update_size(tree, s, strip);
      REQUIRE(begin >= 0);
      REQUIRE(end <= (shared ? plan.shared_arena_size : plan.thread_arena_size));
      for (const int32_t other : alive) {
        if ((plan.update_shared[other] != 0) != shared) continue;
        const int64_t other_begin = plan.update_offset[other];
        REQUIRE((end <= other_begin || other_begin + update_size(tree, other, strip) <= begin));
      }
      std::erase_if(alive, [&](int32_t other) { return tree.parent[other] == s; });
      alive.push_back(s);
      REQUIRE(plan.factor_offset[s + 1] > plan.factor_offset[s]);
    }
    for (const int32_t s : alive) CHECK(tree.parent[s] == -1);
  }
}
