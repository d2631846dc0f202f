#include <doctest/doctest.h>

#include <vector>

#include <stark/geometry/edge_lookup.h>
#include <stark/geometry/shapes.h>
#include <stark/geometry/topology.h>

using namespace stark;

TEST_CASE("Every edge of a mesh is found from both ends") {
  const TriangleMesh sphere = make_icosphere(1.0, 2);
  const std::vector<Index2> edges = find_edges(std::span<const Index3>(sphere.triangles));
  const EdgeLookup lookup(edges);
  for (size_t e = 0; e < edges.size(); ++e) {
    CHECK(lookup.find(edges[e][0], edges[e][1]) == static_cast<int32_t>(e));
    CHECK(lookup.find(edges[e][1], edges[e][0]) == static_cast<int32_t>(e));
  }
}

TEST_CASE("What is no edge is not found, and of equal edges the first is") {
  const std::vector<Index2> edges{{7, 3}, {3, 5}, {3, 7}, {100, 3}};
  const EdgeLookup lookup(edges);
  CHECK(lookup.find(3, 7) == 0);
  CHECK(lookup.find(3, 100) == 3);
  CHECK(lookup.find(5, 7) == -1);
  CHECK(lookup.find(3, 6) == -1);
  CHECK(lookup.find(3, 101) == -1);
  CHECK(lookup.find(0, 1) == -1);
  CHECK(lookup.find(200, 201) == -1);
  CHECK(EdgeLookup({}).find(0, 1) == -1);
}
