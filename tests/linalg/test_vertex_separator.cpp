// Vertex separators.
#include <stark/linalg/vertex_separator.h>

#include <algorithm>

#include <doctest/doctest.h>
#include <stark/linalg/ordering.h>

#include "linalg/systems.h"

using namespace stark;

TEST_CASE("vertex separator: no edge between the sides, and those of a grid are near the straight cut") {
  int32_t count = 0;
  const test::Pairs solid = test::solid_pairs(12, count);
  struct Mesh {
    int32_t count;
    test::Pairs pairs;
    int limit;
  };
  // Straight cuts: two rows of 50 nodes, as hinges reach over one row; one layer of 13 x 13 corners.
  for (const Mesh& mesh : {Mesh{2500, test::cloth_pairs(50), 110}, Mesh{count, solid, 186}}) {
    const AdjacencyGraph graph =
        AdjacencyGraph::from_pattern(BlockPattern::from_pairs(mesh.count, mesh.pairs));
    WeightedGraph weighted{graph.start, graph.neighbor, {}, {}};
    weighted.edge_weight.assign(graph.neighbor.size(), 1);
    weighted.node_weight.assign(mesh.count, 1);
    std::vector<uint8_t> part;
    find_vertex_separator(weighted, part);
    int size[3] = {0, 0, 0};
    for (int32_t i = 0; i < mesh.count; ++i) {
      ++size[part[i]];
      for (int32_t j : graph.neighbors(i)) REQUIRE_FALSE(part[i] + part[j] == 1);
    }
    CHECK(size[kSeparator] <= mesh.limit);
    CHECK(std::max(size[0], size[1]) <= 0.62 * mesh.count);
  }
}
