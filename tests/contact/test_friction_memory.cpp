// What friction remembers: the numbering of pairs keeps their order, the material of a pair shows its
// turning.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include <stark/base/rotation.h>
#include <stark/contact/friction_memory.h>
#include <support/random_points.h>

using namespace stark;
using namespace stark::test;

TEST_CASE("packed pairs have the order of their keys") {
  using enum PairKind;
  constexpr int32_t kMany = 1 << 29;
  const std::vector<PairKey> keys{
      {PointTriangle, 0, 0},     {PointTriangle, 0, 1}, {PointTriangle, 1, 0},
      {PointTriangle, kMany, 7}, {EdgeEdge, 0, 0},      {EdgeEdge, 5, kMany},
      {PointEdge, 0, kMany},     {PointPoint, 0, 0},    {PointPoint, kMany, kMany}};
  FrictionMemory memory;
  for (size_t i = 0; i < keys.size(); ++i) memory.append(keys[i], {static_cast<double>(i), 0, 0}, 1.0);
  CHECK(std::ranges::is_sorted(memory.pair));
  for (size_t i = 0; i < keys.size(); ++i) CHECK(memory.find(keys[i]) == static_cast<int64_t>(i));
  CHECK(memory.find({PointEdge, 3, 4}) == -1);
}

TEST_CASE("pairs of the same first primitive are found together") {
  using enum PairKind;
  FrictionMemory memory;
  for (const PairKey key :
       {PairKey{PointTriangle, 1, 9}, {PointTriangle, 2, 3}, {PointTriangle, 2, 8}, {EdgeEdge, 2, 4}})
    memory.append(key, {}, 1.0);
  CHECK(memory.of_first({PointTriangle, 2, 5}) == std::pair<int64_t, int64_t>{1, 3});
  CHECK(memory.of_first({PointTriangle, 0, 5}) == std::pair<int64_t, int64_t>{0, 0});
  CHECK(memory.of_first({EdgeEdge, 2, 0}) == std::pair<int64_t, int64_t>{3, 4});
  CHECK(memory.of_first({PointEdge, 2, 0}) == std::pair<int64_t, int64_t>{4, 4});
}

TEST_CASE("spin is the angle by which triangles and edges turn about the normal") {
  RandomPoints random(3);
  const SurfaceMesh mesh{.vertex_count = 5, .edges = {{1, 2}, {3, 4}}, .triangles = {{1, 2, 3}}};
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<Vec3> x0, x1;
    for (int i = 0; i < 5; ++i) x0.push_back(random.point());
    const Vec3 normal = normalized(random.point());
    const double angle = random.uniform(-3.0, 3.0);
    const Mat3 R = exp_rotation(normal * angle);
    for (const Vec3& p : x0) x1.push_back(R * p + Vec3{1, 2, 3});
    for (const PairKey key : {PairKey{PairKind::PointTriangle, 0, 0}, PairKey{PairKind::EdgeEdge, 0, 1},
                              PairKey{PairKind::PointEdge, 0, 1}})
      CHECK(spin(mesh, key, normal, x0, x1) == doctest::Approx(angle).epsilon(1e-9));
    CHECK(spin(mesh, {PairKind::PointPoint, 0, 1}, normal, x0, x1) == 0.0);
    const Vec3 along = normalized(x0[2] - x0[1]);
    const Mat3 twist = exp_rotation(along * 0.5);
    for (size_t i = 0; i < x0.size(); ++i) x1[i] = twist * x0[i];
    CHECK(spin(mesh, {PairKind::PointEdge, 0, 0}, along, x0, x1) ==
          0.0);  // an edge does not show turning about itself
  }
}

TEST_CASE("side A of some pairs of edges is the second edge") {
  const SurfaceMesh mesh{.vertex_count = 4, .edges = {{0, 1}, {2, 3}}};
  Contact contact;
  contact.key = {PairKind::EdgeEdge, 0, 1};
  contact.sites = {1, 2, 3, 0};
  CHECK(orientation(mesh, contact) == 1.0);
  contact.sites = {2, 0, 1, 0};
  CHECK(orientation(mesh, contact) == -1.0);
  contact.key = {PairKind::PointEdge, 0, 1};
  CHECK(orientation(mesh, contact) == 1.0);
}
