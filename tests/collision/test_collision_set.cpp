// Queries of a set of primitives: two triangles above each other, a ball over a cloth.
#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <set>
#include <vector>

#include <stark/base/error.h>
#include <stark/collision/collision_set.h>
#include <stark/geometry/distance.h>
#include <stark/geometry/shapes.h>
#include <stark/geometry/topology.h>

using namespace stark;

namespace {

const std::vector<int32_t> kGroups{0, 0, 0, 1, 1, 1};
const std::vector<Index2> kEdges{{0, 1}, {1, 2}, {0, 2}, {3, 4}, {4, 5}, {3, 5}};
const std::vector<Index3> kTriangles{{0, 1, 2}, {3, 4, 5}};
const std::vector<double> kNone{0.0, 0.0};

/// The second triangle is at this height.
std::vector<Vec3> positions(double height) {
  return {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.1, 0.1, height}, {1.1, 0.1, height}, {0.1, 1.1, height}};
}

using Pairs = std::set<std::pair<int32_t, int32_t>>;

Pairs sorted_and_unique(const std::vector<PrimitivePair>& pairs) {
  CHECK(std::is_sorted(pairs.begin(), pairs.end()));
  Pairs set;
  for (const PrimitivePair& pair : pairs) set.emplace(pair.first, pair.second);
  CHECK(set.size() == pairs.size());
  return set;
}

}  // namespace

TEST_CASE("candidates hold every pair of features in reach, and sort them") {
  std::mt19937 random(13);
  std::uniform_real_distribution<double> noise(-0.01, 0.01);
  for (int round = 0; round < 3; ++round) {
    TriangleMesh both = make_grid(1.0, 1.0, 9, 9);
    const TriangleMesh ball = make_icosphere(0.3, 2);
    const auto count = static_cast<int32_t>(both.vertices.size());
    for (const Vec3& v : ball.vertices) both.vertices.push_back(v + Vec3{0.0, 0.0, 0.32});
    for (const Index3& t : ball.triangles)
      both.triangles.push_back({t[0] + count, t[1] + count, t[2] + count});
    std::vector<int32_t> groups(both.vertices.size(), 0);
    std::fill(groups.begin() + count, groups.end(), 1);
    for (Vec3& v : both.vertices) v += {noise(random), noise(random), noise(random)};
    const auto& [x, triangles] = both;
    const std::vector<Index2> edges = find_edges(triangles);
    constexpr double kReach = 0.1;
    const std::vector<double> inflation(2, 0.5 * kReach);
    CollisionSet set(groups, edges, triangles);
    const CandidateList found = set.find(x, x, inflation);
    const Pairs point_triangle = sorted_and_unique(found[PairKind::PointTriangle]);
    const Pairs edge_edge = sorted_and_unique(found[PairKind::EdgeEdge]);
    int near = 0, missing = 0;
    for (int32_t p = 0; p < static_cast<int32_t>(x.size()); ++p)
      for (int32_t t = 0; t < static_cast<int32_t>(triangles.size()); ++t) {
        const auto [a, b, c] = triangles[t];
        if (p == a || p == b || p == c) continue;
        if (point_triangle_squared_distance(x[p], x[a], x[b], x[c]) > kReach * kReach) continue;
        missing += !point_triangle.contains({p, t});
      }
    for (int32_t e = 0; e < static_cast<int32_t>(edges.size()); ++e)
      for (int32_t f = e + 1; f < static_cast<int32_t>(edges.size()); ++f) {
        const auto [a, b] = edges[e];
        const auto [c, d] = edges[f];
        if (a == c || a == d || b == c || b == d) continue;
        if (edge_edge_squared_distance(x[a], x[b], x[c], x[d]) > kReach * kReach) continue;
        ++near;
        missing += !edge_edge.contains({e, f});
      }
    CHECK(near > 1000);
    CHECK(missing == 0);
  }
}

TEST_CASE("a motion into another group ends before it") {
  CollisionSet set(kGroups, kEdges, kTriangles);
  const CcdReport report = set.max_safe_step(positions(1.0), positions(-1.0), kNone);
  CHECK(report.step > 0.4);
  CHECK(report.step < 0.5);
  CHECK(report.kind.has_value());
  CHECK(set.find(positions(1.0), positions(-1.0), kNone).size() > 0);
  CHECK(set.find(positions(1.0), positions(0.5), kNone).size() == 0);
}

TEST_CASE("excluded pairs may meet") {
  const std::vector<Index2> excluded{{0, 1}};
  CollisionSet set(kGroups, kEdges, kTriangles, {}, excluded);
  CHECK(set.max_safe_step(positions(1.0), positions(-1.0), kNone).step == 1.0);
}

TEST_CASE("what intersects is found") {
  std::vector<Vec3> x = positions(0.2);
  CollisionSet set(kGroups, kEdges, kTriangles);
  CHECK(set.find_intersections(x).empty());
  CHECK(set.find_contained_groups(x).empty());
  x[3].z = -0.2;
  CHECK(!set.find_intersections(x).empty());
}

TEST_CASE("positions are as many as vertices") {
  CollisionSet set(kGroups, kEdges, kTriangles);
  const std::vector<Vec3> two(2);
  CHECK_THROWS_WITH_AS(set.find_intersections(two), "x: got 2 rows: must be 6, one for each vertex",
                       InvalidArgument);
}
