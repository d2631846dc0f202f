// Directions of surfaces: tangents that go with the deforming triangle, and means of them at edges and
// vertices by the areas that the contact sees.
#include <doctest/doctest.h>

#include <cmath>

#include <stark/contact/surface_directions.h>

#include <support/random_points.h>

using namespace stark;
using namespace stark::test;

namespace {

/// A floor triangle of group 0, and an L of two triangles of group 1 that share the edge 3-4.
SurfaceMesh mesh() {
  return {.vertex_count = 7,
          .edges = {{0, 1}, {3, 4}, {3, 5}},
          .triangles = {{0, 1, 2}, {3, 4, 5}, {4, 3, 6}},
          .vertex_group = {0, 0, 0, 1, 1, 1, 1},
          .edge_group = {0, 1, 1},
          .triangle_group = {0, 1, 1}};
}

std::vector<Vec3> positions() {
  return {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {0, 0, 2}};
}

/// Directions in the plane of each triangle.
SurfaceDirections directions(const Vec3& floor, const Vec3& level, const Vec3& upright) {
  const std::vector<Vec3> x = positions();
  return {mesh(),
          {tangent_components(x[0], x[1], x[2], floor), tangent_components(x[3], x[4], x[5], level),
           tangent_components(x[4], x[3], x[6], upright)}};
}

/// The sign of a direction means nothing.
bool same_line(const Vec3& a, const Vec3& b) { return std::fabs(std::fabs(dot(a, b)) - 1.0) < 1e-12; }

}  // namespace

TEST_CASE("tangents are the parts of directions in the plane, of unit length") {
  RandomPoints random(3);
  for (int trial = 0; trial < 20; ++trial) {
    const Vec3 x0 = random.point(), x1 = random.point(), x2 = random.point(), d = random.point();
    const auto [a, b] = tangent_components(x0, x1, x2, d * 7.0);
    const Vec3 n = normalized(cross(x1 - x0, x2 - x0)), expected = normalized(d - n * dot(n, d));
    CHECK(norm((x1 - x0) * a + (x2 - x0) * b - expected) < 1e-9);
    CHECK(tangent_components(x0, x1, x2, n) == TangentComponents{});
  }
}

TEST_CASE("directions are carried along with the triangle") {
  const SurfaceMesh m = mesh();
  const SurfaceDirections set = directions({1, 1, 0}, {1, 0, 0}, {1, 0, 0});
  const PairKey key{PairKind::PointTriangle, 5, 0};  // a point of the L against the floor
  std::vector<Vec3> x = positions();
  CHECK(same_line(set.of_pair(m, key, 0, {0, 0, 1}, x), normalized(Vec3{1, 1, 0})));
  x[1] = {3, 0, 0};  // stretched threefold along x: the diagonal leans
  CHECK(same_line(set.of_pair(m, key, 0, {0, 0, 1}, x), normalized(Vec3{3, 1, 0})));
  x[1] = {0, 1, 0};  // turned by a quarter
  x[2] = {-1, 0, 0};
  CHECK(same_line(set.of_pair(m, key, 0, {0, 0, 1}, x), normalized(Vec3{-1, 1, 0})));
  // Contact along another normal sees its part in the plane.
  const Vec3 n = normalized(Vec3{1, 0, 1});
  x = positions();
  const Vec3 seen = set.of_pair(m, key, 0, n, x), d{1, 1, 0};
  CHECK(same_line(seen, normalized(d - n * dot(n, d))));
}

TEST_CASE("edges and vertices have the mean of their triangles, by the areas in sight") {
  const SurfaceMesh m = mesh();
  const std::vector<Vec3> x = positions();
  const SurfaceDirections set = directions({1, 0, 0}, {1, 2, 0}, {0, 0, 1});
  const PairKey vertex{PairKind::PointTriangle, 3, 0}, edge{PairKind::EdgeEdge, 0, 1};
  // From below only the level triangle is in sight, from the side only the upright one.
  for (const PairKey& key : {vertex, edge}) {
    CHECK(same_line(set.of_pair(m, key, 1, {0, 0, 1}, x), normalized(Vec3{1, 2, 0})));
    CHECK(same_line(set.of_pair(m, key, 1, {0, 1, 0}, x), Vec3{0, 0, 1}));
  }
  // Halfway both count alike, and opposite signs are one direction.
  const Vec3 n = normalized(Vec3{0, 1, 1});
  for (const double sign : {1.0, -1.0}) {
    const SurfaceDirections both = directions({1, 0, 0}, {1, 0, 0}, {sign, 0, 0});
    CHECK(same_line(both.of_pair(m, vertex, 1, n, x), Vec3{1, 0, 0}));
  }
  // The edge 3-5 belongs to the level triangle alone.
  CHECK(same_line(set.of_pair(m, {PairKind::EdgeEdge, 0, 2}, 1, {0, 0, 1}, x), normalized(Vec3{1, 2, 0})));
}

TEST_CASE("without a direction in the plane there is none") {
  const SurfaceMesh m = mesh();
  const std::vector<Vec3> x = positions();
  const SurfaceDirections set = directions({0, 0, 1}, {0, 0, 1}, {0, 0, 1});
  CHECK(set.of_pair(m, {PairKind::PointTriangle, 5, 0}, 0, {0, 0, 1}, x) == Vec3{});
  // The upright triangle has one, along the normal of the contact.
  CHECK(set.of_pair(m, {PairKind::PointTriangle, 3, 0}, 1, {0, 0, 1}, x) == Vec3{});
  CHECK(set.of_pair(m, {PairKind::PointPoint, 0, 3}, 1, {0, 0, 1}, x) == Vec3{});
  CHECK(SurfaceDirections().of_pair(m, {PairKind::PointTriangle, 5, 0}, 0, {0, 0, 1}, x) == Vec3{});
}
