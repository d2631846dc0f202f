// The table of pair kinds: rows in the order of the enumeration, with the primitives that their names say.
#include <doctest/doctest.h>

#include <string>

#include <stark/collision/primitive_pairs.h>

#include "support/random_points.h"

using namespace stark;
using namespace stark::test;

namespace {

/// Two triangles of bodies 0 and 1 that share nothing, with an edge each.
SurfaceMesh mesh() {
  SurfaceMesh m;
  m.vertex_count = 6;
  m.triangles = {{0, 1, 2}, {3, 4, 5}};
  m.edges = {{0, 1}, {4, 5}};
  m.vertex_group = {0, 0, 0, 1, 1, 1};
  m.edge_group = {0, 1};
  m.triangle_group = {0, 1};
  return m;
}

}  // namespace

TEST_CASE("pair kinds: each row once, in the order of the enumeration") {
  int row = 0;
  for_each_pair_kind([&](auto kind) {
    CHECK(static_cast<int>(kind.value) == row++);
    CHECK(with_pair_kind(kind, [](auto tag) { return tag.value; }) == kind);
  });
  CHECK(row == kPairKindCount);
}

TEST_CASE("pair kinds: names, primitives, vertices and groups agree") {
  const SurfaceMesh m = mesh();
  const std::string primitives[] = {"point", "edge", "triangle"};
  const PrimitivePair pair{0, 1};
  for_each_pair_kind([&](auto kind) {
    using Row = PairRow<kind.value>;
    CAPTURE(to_string(kind));
    const auto name = [&](PrimitiveKind k) { return primitives[static_cast<int>(k)]; };
    CHECK(to_string(kind) == name(first_kind(kind)) + "_" + name(second_kind(kind)));
    const auto vertices = Row::vertices(m, pair);
    const auto first = vertices_of(m, Row::kFirst, pair.first),
               second = vertices_of(m, Row::kSecond, pair.second);
    CHECK(std::vector(vertices.begin(), vertices.begin() + Row::kFirstCount) ==
          std::vector(first.begin(), first.end()));
    CHECK(std::vector(vertices.begin() + Row::kFirstCount, vertices.end()) ==
          std::vector(second.begin(), second.end()));
    for (const int32_t v : first) CHECK(m.vertex_group[v] == Row::groups(m, pair).first);
    for (const int32_t v : second) CHECK(m.vertex_group[v] == Row::groups(m, pair).second);
  });
}

TEST_CASE("pair kinds: distance and collision detection are those of the primitives") {
  const SurfaceMesh m = mesh();
  RandomPoints random(7);
  for (int trial = 0; trial < 100; ++trial) {
    std::vector<Vec3> x(6);
    for (Vec3& p : x) p = random.point();
    const Index3 &s = m.triangles[0], &t = m.triangles[1];
    const Index2 &a = m.edges[0], &b = m.edges[1];
    const auto at = [&](PairKind kind, int32_t first) { return squared_distance(m, kind, {first, 1}, x); };
    CHECK(at(PairKind::PointTriangle, s[0]) ==
          point_triangle_squared_distance(x[s[0]], x[t[0]], x[t[1]], x[t[2]]));
    CHECK(at(PairKind::EdgeEdge, 0) == edge_edge_squared_distance(x[a[0]], x[a[1]], x[b[0]], x[b[1]]));
    CHECK(at(PairKind::PointEdge, s[2]) == point_edge_squared_distance(x[s[2]], x[b[0]], x[b[1]]));
    CHECK(at(PairKind::PointPoint, s[0]) == squared_norm(x[s[0]] - x[1]));
    // What moves together never meets; two bodies that pass through each other do.
    std::vector<Vec3> moved = x;
    for (Vec3& p : moved) p += Vec3{3, 0, 0};
    for_each_pair_kind([&](auto kind) {
      using Row = PairRow<kind.value>;
      CHECK(Row::kCcd(Row::positions(m, {0, 1}, x), Row::positions(m, {0, 1}, moved), 1e-9, {}) == 1.0);
    });
  }
}
