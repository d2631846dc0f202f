// Queries of a set of primitives: two triangles above each other.
#include <doctest/doctest.h>

#include <vector>

#include <stark/base/error.h>
#include <stark/collision/collision_set.h>

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

}  // namespace

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
