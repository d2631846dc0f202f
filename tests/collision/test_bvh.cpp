// Overlapping cells against brute force; ownership of vertices and edges.
#include <doctest/doctest.h>

#include <array>
#include <set>

#include <stark/collision/bvh.h>
#include <stark/geometry/shapes.h>

#include "support/collision_scenes.h"
#include "support/random_points.h"
#include "support/slab_oracle.h"

using namespace stark;
using detail::Box;
using detail::Bvh;
using detail::Cell;
using detail::MovingBox;
using test::RandomPoints;
using test::SceneBuilder;

TEST_CASE("every pair of overlapping triangles that no slab keeps apart is visited exactly once") {
  RandomPoints random(61);
  // Sizes around the powers of eight at which the tree gets another level.
  for (const int cells : {1, 2, 3, 5, 6, 16, 18}) {
    SceneBuilder scene;
    scene.add_mesh(make_grid(1.0, 1.0, cells, cells));
    scene.add_mesh(make_grid(1.0, 1.0, 4, 4), {0, 0, 0.01});
    for (Vec3& v : scene.x) v += random.point() * 0.02;
    const std::vector<double> inflation = {0.003, 0.001};
    ThreadPool pool(1);
    Bvh bvh;
    bvh.reset(scene.surface, 2);
    for (int round = 0; round < 2; ++round) {
      bvh.refit(scene.x, inflation, pool);
      std::set<Index2> visited;
      bool twice = false;
      bvh.for_each_pair<Box>(PairFilter(2), pool, [&](int, const Cell& a, const Cell& b, bool same_group) {
        const Index2 pair{std::min(a.triangle, b.triangle), std::max(a.triangle, b.triangle)};
        twice = twice || !visited.insert(pair).second;
        CHECK(same_group ==
              (scene.surface.triangle_group[a.triangle] == scene.surface.triangle_group[b.triangle]));
      });
      CHECK_FALSE(twice);
      size_t expected = 0;
      const auto& triangles = scene.surface.triangles;
      const test::SlabOracle slabs(scene.surface, scene.x, scene.x, inflation);
      for (int32_t a = 0; a < static_cast<int32_t>(triangles.size()); ++a) {
        for (int32_t b = a + 1; b < static_cast<int32_t>(triangles.size()); ++b) {
          bool overlap = true;
          for (int axis = 0; axis < 3; ++axis) {
            double low[2], high[2];
            for (int k = 0; k < 2; ++k) {
              const Index3& t = triangles[k == 0 ? a : b];
              const double r = inflation[scene.surface.triangle_group[k == 0 ? a : b]];
              low[k] = std::min({scene.x[t[0]][axis], scene.x[t[1]][axis], scene.x[t[2]][axis]}) - r;
              high[k] = std::max({scene.x[t[0]][axis], scene.x[t[1]][axis], scene.x[t[2]][axis]}) + r;
            }
            overlap = overlap && low[0] <= high[1] && low[1] <= high[0];
          }
          if (!overlap) continue;
          ++expected;
          if (visited.count({a, b}) == 1) continue;
          // Only of different groups.
          CHECK(scene.surface.triangle_group[a] != scene.surface.triangle_group[b]);
          CHECK(slabs.may_part(triangles[a], triangles[b]));
        }
      }
      // Boxes rounded outwards by 1e-7 may add a pair, but hardly ever do.
      CHECK(visited.size() <= expected + 2);
      for (Vec3& v : scene.x) v += random.point() * 0.05;
    }
  }
}

TEST_CASE("boxes in single precision contain the points far from the origin") {
  RandomPoints random(62);
  SceneBuilder scene;
  std::vector<Vec3> particles;
  const Vec3 shift{1.23456789e6, -9.87654321e5, 3.3e3};
  for (int k = 0; k < 500; ++k)
    particles.push_back(random.point() * std::pow(10.0, random.uniform(-6, 2)) + shift);
  scene.add_particles(particles);
  ThreadPool pool(1);
  Bvh bvh;
  bvh.reset(scene.surface, 1);
  const std::vector<double> inflation = {0.0};
  bvh.refit(scene.x, inflation, pool);
  bvh.for_each_pair<Box>(PairFilter(1), pool, [](int, const Cell&, const Cell&, bool) {});
  const Vec3& origin = bvh.origin();
  for (int32_t v = 0; v < 500; ++v) {
    for (int axis = 0; axis < 3; ++axis) {
      const long double p = static_cast<long double>(scene.x[v][axis]) - origin[axis];
      CHECK(bvh.vertex_extent<Box>(v).low[axis] < p);
      CHECK(bvh.vertex_extent<Box>(v).high[axis] > p);
      CHECK(bvh.vertex_extent<Box>(v).high[axis] - bvh.vertex_extent<Box>(v).low[axis] < 1e-4);
    }
  }
}

TEST_CASE("places that floats cannot reach are found together, and nothing else is touched") {
  SceneBuilder scene;
  scene.add_mesh(make_grid(1.0, 1.0, 9, 9));
  scene.add_mesh(make_grid(1.0, 1.0, 4, 4), {0, 0, 5.0});
  for (size_t v = 0; v < scene.x.size(); v += 3)
    for (int axis = 0; axis < 3; ++axis) scene.x[v][axis] = (v / 3 + axis) % 2 == 0 ? 1e300 : -1e300;
  ThreadPool pool(1);
  Bvh bvh;
  bvh.reset(scene.surface, 2);
  const std::vector<double> inflation = {0.001, 0.001};
  bvh.refit(scene.x, inflation, pool);
  const auto count = static_cast<int32_t>(scene.surface.triangles.size());
  int64_t pairs = 0;
  bvh.for_each_pair<Box>(PairFilter(2), pool, [&](int, const Cell& a, const Cell& b, bool) {
    REQUIRE((a.triangle >= 0 && a.triangle < count && b.triangle >= 0 && b.triangle < count));
    ++pairs;
  });
  CHECK(pairs > 0);
  // On the way there from the grids, too.
  std::vector<Vec3> start = scene.x;
  for (size_t v = 0; v < start.size(); v += 3) start[v] = {0.001 * static_cast<double>(v), 0.5, 0.1};
  bvh.refit(start, scene.x, inflation, pool);
  int64_t moving = 0;
  bvh.for_each_pair<MovingBox>(PairFilter(2), pool, [&](int, const Cell& a, const Cell& b, bool) {
    REQUIRE((a.triangle >= 0 && a.triangle < count && b.triangle >= 0 && b.triangle < count));
    ++moving;
  });
  CHECK(moving >= pairs);
}

TEST_CASE("the tree of a group that rests is kept, and finds what a new one finds") {
  SceneBuilder scene;
  scene.add_mesh(make_icosphere(1.0, 4));
  scene.add_mesh(make_box({0.1, 0.1, 0.1}), {0.0, 0.0, 1.06});
  std::vector<int32_t> ball;
  for (int32_t v = 0; v < scene.surface.vertex_count; ++v)
    if (scene.surface.vertex_group[v] == 0) ball.push_back(v);
  scene.surface.frames = {find_frame(ball, scene.x), std::nullopt};
  REQUIRE(scene.surface.frames[0].has_value());
  const std::vector<double> inflation = {0.02, 0.02};
  const PairFilter filter(2);
  ThreadPool pool(1);
  using Pairs = std::set<Index2>;
  const auto find_pairs = [&]<typename Extent>(Bvh& bvh, std::span<const Vec3> x0, std::span<const Vec3> x1) {
    if constexpr (std::is_same_v<Extent, Box>)
      bvh.refit(x0, inflation, pool);
    else
      bvh.refit(x0, x1, inflation, pool);
    Pairs pairs;
    bvh.for_each_pair<Extent>(filter, pool, [&](int, const Cell& a, const Cell& b, bool) {
      pairs.insert({std::min(a.triangle, b.triangle), std::max(a.triangle, b.triangle)});
    });
    return pairs;
  };
  Bvh bvh;
  bvh.reset(scene.surface, 2);
  size_t found = 0;
  int32_t fitted_at_rest = 0, fitted_with_ball = 0;
  for (int round = 0; round < 40; ++round) {
    const bool moves_ball = round % 10 == 9;
    std::vector<Vec3> end = scene.x;
    for (size_t v = 0; v < end.size(); ++v)
      if (scene.surface.vertex_group[v] == 1 || moves_ball) end[v] += Vec3{0.003, -0.002, 0.001};
    const auto compare = [&]<typename Extent>() {
      const Pairs pairs = find_pairs.operator()<Extent>(bvh, scene.x, end);
      if (round > 0) (moves_ball ? fitted_with_ball : fitted_at_rest) += bvh.fitted();
      Bvh fresh;
      fresh.reset(scene.surface, 2);
      const Pairs expected = find_pairs.operator()<Extent>(fresh, scene.x, end);
      CHECK(std::ranges::includes(pairs, expected));
      CHECK(pairs.size() <= expected.size() + 2);  // boxes of what rests are 1e-6 m larger
      found += pairs.size();
    };
    compare.operator()<MovingBox>();
    scene.x = end;
    compare.operator()<Box>();
  }
  CHECK(found > 1000);
  // Of the box, and of the ball where its last move ended.
  CHECK(fitted_at_rest <= 2 * 36 + 2 * 3);
  CHECK(fitted_with_ball == 4 * 4);
}
