// Scene-level intersection test against brute force; containment.
#include <doctest/doctest.h>

#include <stark/collision/intersection.h>
#include <stark/geometry/distance.h>
#include <stark/geometry/intersection.h>
#include <stark/geometry/shapes.h>

#include "support/collision_scenes.h"
#include "support/random_points.h"

using namespace stark;
using test::RandomPoints;
using test::SceneBuilder;

TEST_CASE("edge-triangle intersections equal brute force") {
  RandomPoints random(51);
  ThreadPool pool(2);
  int total = 0;
  for (int round = 0; round < 20; ++round) {
    SceneBuilder scene;
    scene.add_mesh(make_grid(1.0, 1.0, 9, 9));
    scene.add_mesh(make_icosphere(0.3, 2), random.point() * 0.3);
    scene.add_mesh(make_box({0.3, 0.3, 0.3}, 2), random.point() * 0.3);
    scene.add_rod({random.point() * 0.4, random.point() * 0.4, random.point() * 0.4});
    for (Vec3& v : scene.x) v += random.point() * 0.02;
    PairFilter filter(4);
    if (round % 2) filter.set(0, 1, false);
    const SurfaceMesh& mesh = scene.surface;
    std::vector<EdgeTriangleIntersection> expected;
    for (size_t e = 0; e < mesh.edges.size(); ++e) {
      for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Index2& i = mesh.edges[e];
        const Index3& j = mesh.triangles[t];
        bool shared = false;
        for (const int32_t v : i) shared = shared || v == j[0] || v == j[1] || v == j[2];
        if (shared || !filter.allowed(mesh.edge_group[e], mesh.triangle_group[t])) continue;
        if (segment_intersects_triangle(scene.x[i[0]], scene.x[i[1]], scene.x[j[0]], scene.x[j[1]],
                                        scene.x[j[2]])) {
          expected.push_back({static_cast<int32_t>(e), static_cast<int32_t>(t)});
        }
      }
    }
    total += static_cast<int>(expected.size());
    CHECK(find_intersections(mesh, scene.x, filter, pool) == expected);
  }
  CHECK(total > 200);
}

TEST_CASE("bodies that share an exact plane touch, a gap of one ulp does not") {
  SceneBuilder scene;
  scene.add_mesh(make_box({1, 1, 1}), {0, 0, 0.5});
  scene.add_mesh(make_grid(4, 4, 1, 1));
  ThreadPool pool(1);
  CHECK_FALSE(find_intersections(scene.surface, scene.x, PairFilter(2), pool).empty());
  for (Vec3& v : scene.x) {
    if (v.z == 0.0 && std::fabs(v.x) < 1.0) v.z = 5e-324;
  }
  CHECK(find_intersections(scene.surface, scene.x, PairFilter(2), pool).empty());
}

TEST_CASE("contained bodies are found, open and filtered ones are not") {
  SceneBuilder scene;
  const int32_t outer = scene.add_mesh(make_torus(1.0, 0.4));
  const int32_t inside = scene.add_mesh(make_box({0.1, 0.1, 0.1}), {1, 0, 0});
  scene.add_mesh(make_box({0.1, 0.1, 0.1}));  // in the hole
  const int32_t particle = scene.add_particles({{0, 0, 3}, {0, 1.1, 0.1}});
  const int32_t rod = scene.add_rod({{-1, 0, 0}, {-1, 0.05, 0}});
  const int32_t sheet = scene.add_mesh(make_grid(0.1, 0.1, 2, 2), {0, -1, 0.03});
  ThreadPool pool(2);
  PairFilter filter(6);
  auto found = find_contained_groups(scene.surface, scene.x, filter, pool);
  REQUIRE(found.size() == 4);
  CHECK(found[0].inner == inside);
  CHECK(found[1].inner == particle);
  CHECK(found[2].inner == rod);
  CHECK(found[3].inner == sheet);
  for (const ContainedGroup& c : found) {
    CHECK(c.outer == outer);
    CHECK(scene.surface.vertex_group[c.vertex] == c.inner);
  }
  CHECK(scene.x[found[1].vertex] == Vec3{0, 1.1, 0.1});
  filter.set(outer, inside, false);
  CHECK(find_contained_groups(scene.surface, scene.x, filter, pool).size() == 3);
  std::vector<bool> filled(6, true);
  filled[outer] = false;
  CHECK(find_contained_groups(scene.surface, scene.x, filter, pool, filled).empty());
}

TEST_CASE("a finder that is used again finds what a new one finds, wherever bodies have gone") {
  RandomPoints random(52);
  SceneBuilder scene;
  scene.add_mesh(make_icosphere(0.3, 2));
  scene.add_mesh(make_box({0.2, 0.2, 0.2}, 2));
  scene.add_mesh(make_grid(0.5, 0.5, 5, 5));
  const std::vector<Vec3> at_rest = scene.x;
  ThreadPool pool(2);
  const PairFilter filter(3);
  IntersectionFinder finder(scene.surface, 3, {true, false, true});
  size_t crossing = 0, contained = 0;
  for (int round = 0; round < 30; ++round) {
    const Vec3 moves[] = {random.point() * 3.0, random.point() * 3.0, random.point() * 0.1};
    for (size_t v = 0; v < scene.x.size(); ++v)
      scene.x[v] = at_rest[v] + moves[scene.surface.vertex_group[v]] * (round % 3 == 0 ? 0.05 : 0.3);
    const auto edges = finder.intersections(scene.x, filter, pool);
    const auto groups = finder.contained_groups(scene.x, filter, pool);
    CHECK(edges == find_intersections(scene.surface, scene.x, filter, pool));
    CHECK(groups == find_contained_groups(scene.surface, scene.x, filter, pool, {true, false, true}));
    crossing += edges.size(), contained += groups.size();
    for (const ContainedGroup& group : groups) CHECK(group.outer == 0);  // the box is hollow, the grid open
  }
  CHECK(crossing > 50);
  CHECK(contained > 3);
}

TEST_CASE("closest points equal brute force over all primitives, wherever bodies are") {
  RandomPoints random(53);
  SceneBuilder scene;
  scene.add_mesh(make_icosphere(0.3, 2));
  scene.add_mesh(make_box({0.2, 0.3, 0.1}, 3));
  scene.add_rod({{0, 0, 0}, {0.1, 0, 0}, {0.2, 0.1, 0}});
  const std::vector<Vec3> at_rest = scene.x;
  const SurfaceMesh& mesh = scene.surface;
  ThreadPool pool(2);
  IntersectionFinder finder(mesh, 3);
  int meeting = 0;
  for (int round = 0; round < 40; ++round) {
    const double way = round % 4 == 0 ? 20.0 : 0.5;
    const Vec3 moves[] = {random.point() * way, random.point() * way, random.point() * way};
    for (size_t v = 0; v < scene.x.size(); ++v) scene.x[v] = at_rest[v] + moves[mesh.vertex_group[v]];
    for (const auto& [a, b] : {std::pair{0, 1}, {1, 0}, {0, 2}, {2, 1}}) {
      const ClosestPoints found = finder.closest_points(scene.x, a, b, pool);
      PairFilter only(3, false, false);
      only.set(a, b, true);
      if (!find_intersections(mesh, scene.x, only, pool).empty()) {
        CHECK(found.distance == 0.0);
        ++meeting;
        continue;
      }
      double least = HUGE_VAL;
      const auto& x = scene.x;
      for (size_t t = 0; t < mesh.triangles.size(); ++t)
        for (int32_t v = 0; v < mesh.vertex_count; ++v) {
          const int32_t other = mesh.triangle_group[t] == a ? b : mesh.triangle_group[t] == b ? a : -1;
          const Index3& i = mesh.triangles[t];
          if (mesh.vertex_group[v] == other)
            least = std::min(least, point_triangle_squared_distance(x[v], x[i[0]], x[i[1]], x[i[2]]));
        }
      for (size_t e = 0; e < mesh.edges.size(); ++e)
        for (size_t f = 0; f < mesh.edges.size(); ++f) {
          if (mesh.edge_group[e] != a || mesh.edge_group[f] != b) continue;
          const Index2 &i = mesh.edges[e], &j = mesh.edges[f];
          least = std::min(least, edge_edge_squared_distance(x[i[0]], x[i[1]], x[j[0]], x[j[1]]));
        }
      CHECK(found.distance == doctest::Approx(std::sqrt(least)).epsilon(1e-12));
      CHECK(norm(found.point_a - found.point_b) == found.distance);
    }
  }
  CHECK(meeting > 3);
}
