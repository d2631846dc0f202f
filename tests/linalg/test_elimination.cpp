// Assembly trees against elimination on a boolean matrix.
#include <stark/linalg/elimination.h>

#include <algorithm>
#include <set>
#include <span>

#include <doctest/doctest.h>
#include <stark/linalg/ordering.h>

#include "linalg/systems.h"

namespace {

using namespace stark;

// Columns of L as sets, by elimination on a boolean matrix.
std::vector<std::set<int32_t>> eliminate_densely(const BlockPattern& pattern,
                                                 const std::vector<int32_t>& order) {
  const int32_t n = pattern.block_count;
  std::vector<int32_t> position(n);
  for (int32_t p = 0; p < n; ++p) position[order[p]] = p;
  std::vector<std::set<int32_t>> columns(n);
  for (int32_t i = 0; i < n; ++i)
    for (int64_t k = pattern.row_start[i]; k < pattern.row_start[i + 1]; ++k) {
      const int32_t a = position[i], b = position[pattern.column[k]];
      columns[std::min(a, b)].insert(std::max(a, b));
    }
  for (int32_t j = 0; j < n; ++j) {
    std::vector<int32_t> rows(columns[j].upper_bound(j), columns[j].end());
    if (!rows.empty()) columns[rows[0]].insert(rows.begin(), rows.end());
  }
  return columns;
}

double dense_flops(const std::vector<std::set<int32_t>>& columns) {
  double flops = 0.0;
  for (const auto& column : columns)
    for (int k = 0; k < 3; ++k) {
      const double length = 3.0 * static_cast<double>(column.size()) - k;
      flops += length * length;
    }
  return flops;
}

}  // namespace

TEST_CASE("elimination: the assembly tree holds exactly the fill of its order, apart from amalgamation") {
  ThreadPool pool(1);
  for (const test::GraphCase& c : test::ordering_cases()) {
    if (c.block_count > 700) continue;
    CAPTURE(c.name);
    const BlockPattern pattern = BlockPattern::from_pairs(c.block_count, c.pairs);
    const std::vector<int32_t> order = fill_reducing_order(AdjacencyGraph::from_pattern(pattern), pool);
    SymbolicFactorization symbolic;
    AssemblyTree tree;
    symbolic.analyze(pattern, order, 12, tree);
    REQUIRE(test::is_permutation_of_all(tree.order, c.block_count));
    // Same flops for the order asked for and for the equivalent one chosen.
    CHECK(tree.flops == doctest::Approx(dense_flops(eliminate_densely(pattern, order))).epsilon(1e-12));
    const auto columns = eliminate_densely(pattern, tree.order);
    CHECK(tree.flops == doctest::Approx(dense_flops(columns)).epsilon(1e-12));
    int64_t entries = 0;
    for (int32_t s = 0; s < tree.supernode_count(); ++s) {
      const std::span<const int32_t> rows(tree.row.data() + tree.row_start[s],
                                          static_cast<size_t>(tree.row_count(s)));
      REQUIRE(std::is_sorted(rows.begin(), rows.end()));
      std::set<int32_t> front(rows.begin(), rows.end());
      for (int32_t p = tree.first[s]; p < tree.first[s + 1]; ++p) front.insert(p);
      for (int32_t p = tree.first[s]; p < tree.first[s + 1]; ++p)
        REQUIRE(std::includes(front.begin(), front.end(), columns[p].begin(), columns[p].end()));
      // Update rows go to the same positions of the parent's front.
      const int32_t up = tree.parent[s];
      if (rows.empty()) CHECK(up == -1);
      for (size_t k = 0; k < rows.size(); ++k) {
        REQUIRE(up > s);
        const int32_t relative = tree.relative[tree.row_start[s] + static_cast<int64_t>(k)];
        const int32_t width = tree.column_count(up);
        const int32_t there =
            relative < width ? tree.first[up] + relative : tree.row[tree.row_start[up] + relative - width];
        REQUIRE(there == rows[k]);
      }
      entries += tree.entry_start[s + 1] - tree.entry_start[s];
    }
    CHECK(entries == pattern.slot_count());
  }
}
