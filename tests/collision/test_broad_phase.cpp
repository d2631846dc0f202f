// Candidates against brute force: complete (no pair in reach is missing), exact (no pair whose boxes are
// apart), sorted, unique, independent of threads and history.
#include <doctest/doctest.h>

#include <algorithm>
#include <numbers>
#include <set>

#include <stark/base/error.h>
#include <stark/collision/broad_phase.h>
#include <stark/geometry/distance.h>
#include <stark/geometry/shapes.h>

#include "support/collision_scenes.h"
#include "support/random_points.h"
#include "support/slab_oracle.h"

using namespace stark;
using test::includes;
using test::RandomPoints;
using test::SceneBuilder;

namespace {

struct DoubleBox {
  Vec3 low{HUGE_VAL, HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
};

struct MovingBox {
  DoubleBox start, motion;
};

template <size_t N>
MovingBox box_of(const std::array<int32_t, N>& ids, std::span<const Vec3> x0, std::span<const Vec3> x1,
                 double r) {
  MovingBox box;
  for (const int32_t v : ids) {
    for (int k = 0; k < 3; ++k) {
      box.start.low[k] = std::min(box.start.low[k], x0[v][k] - r);
      box.start.high[k] = std::max(box.start.high[k], x0[v][k] + r);
      box.motion.low[k] = std::min(box.motion.low[k], x1[v][k] - x0[v][k]);
      box.motion.high[k] = std::max(box.motion.high[k], x1[v][k] - x0[v][k]);
    }
  }
  return box;
}

// Boxes that overlap by more, or miss by more, than `margin` on all (some) axes, at some time as seen from a.
bool overlap(const MovingBox& a, const MovingBox& b, double margin) {
  for (int k = 0; k < 3; ++k) {
    const double low = b.start.low[k] + std::min(0.0, b.motion.low[k] - a.motion.high[k]);
    const double high = b.start.high[k] + std::max(0.0, b.motion.high[k] - a.motion.low[k]);
    if (a.start.low[k] > high - margin || low > a.start.high[k] - margin) return false;
  }
  return true;
}

template <size_t A, size_t B>
bool share_vertex(const std::array<int32_t, A>& a, const std::array<int32_t, B>& b) {
  for (const int32_t v : a) {
    if (std::find(b.begin(), b.end(), v) != b.end()) return true;
  }
  return false;
}

// All pairs whose boxes overlap by `margin`, by testing everything against everything; without those that a
// slab may keep apart if the pairs are those that must be found.
CandidateList brute_force(const SceneBuilder& scene, const PairFilter& filter, std::span<const Vec3> x0,
                          std::span<const Vec3> x1, const std::vector<double>& inflation, double margin) {
  const SurfaceMesh& mesh = scene.surface;
  const test::SlabOracle slabs(mesh, x0, x1, inflation);
  const bool must_be_found = margin >= 0.0;
  CandidateList list;
  std::set<int32_t> used, with_edge;
  std::set<Index2> triangle_edges;
  for (const Index2& e : mesh.edges) with_edge.insert(e.begin(), e.end());
  for (const Index3& t : mesh.triangles) {
    with_edge.insert(t.begin(), t.end());
    for (int k = 0; k < 3; ++k)
      triangle_edges.insert({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
  }
  used = with_edge;
  used.insert(mesh.points.begin(), mesh.points.end());
  const auto near = [&](const auto& a, int32_t group_a, const auto& b, int32_t group_b) {
    return filter.allowed(group_a, group_b) && !share_vertex(a, b) &&
           overlap(box_of(a, x0, x1, inflation[group_a]), box_of(b, x0, x1, inflation[group_b]), margin) &&
           (!must_be_found || group_a == group_b || !slabs.may_part(a, b));
  };
  for (const int32_t v : used) {
    const std::array<int32_t, 1> point{v};
    const int32_t group = mesh.vertex_group[v];
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
      if (near(point, group, mesh.triangles[t], mesh.triangle_group[t])) {
        list[PairKind::PointTriangle].push_back({v, static_cast<int32_t>(t)});
      }
    }
    for (size_t e = 0; e < mesh.edges.size(); ++e) {
      if (triangle_edges.count(
              {std::min(mesh.edges[e][0], mesh.edges[e][1]), std::max(mesh.edges[e][0], mesh.edges[e][1])}))
        continue;
      if (near(point, group, mesh.edges[e], mesh.edge_group[e]))
        list[PairKind::PointEdge].push_back({v, static_cast<int32_t>(e)});
    }
    if (with_edge.count(v)) continue;
    for (const int32_t w : used) {
      if (w > v && !with_edge.count(w) &&
          near(point, group, std::array<int32_t, 1>{w}, mesh.vertex_group[w])) {
        list[PairKind::PointPoint].push_back({v, w});
      }
    }
  }
  for (size_t a = 0; a < mesh.edges.size(); ++a) {
    for (size_t b = a + 1; b < mesh.edges.size(); ++b) {
      if (near(mesh.edges[a], mesh.edge_group[a], mesh.edges[b], mesh.edge_group[b])) {
        list[PairKind::EdgeEdge].push_back({static_cast<int32_t>(a), static_cast<int32_t>(b)});
      }
    }
  }
  return list;
}

SceneBuilder mixed_scene(RandomPoints& random) {
  SceneBuilder scene;
  scene.add_mesh(make_grid(1.0, 1.0, 12, 12));
  for (int k = 0; k < 5; ++k) scene.add_mesh(make_box({0.2, 0.2, 0.2}, 1 + k % 3), random.point() * 0.5);
  scene.add_mesh(make_icosphere(0.2, 1), {0.1, 0.2, 0.3});
  std::vector<Vec3> rod, particles;
  for (int k = 0; k < 30; ++k)
    rod.push_back({-0.5 + k / 29.0, 0.1 * random.uniform(), 0.1 * random.uniform()});
  for (int k = 0; k < 40; ++k) particles.push_back(random.point() * 0.5);
  scene.add_rod(rod);
  scene.add_particles(particles);
  scene.add_mesh(make_grid(4.0, 4.0, 1, 1), {0, 0, -0.2});
  return scene;
}

}  // namespace

TEST_CASE("candidates equal brute force on boxes, at rest and under random motion, with any thread count") {
  RandomPoints random(31);
  SceneBuilder scene = mixed_scene(random);
  PairFilter filter(scene.group_count);
  filter.set(1, 2, false);
  filter.set(1, 1, false);
  filter.set(scene.group_count - 1, 0, false);
  BroadPhase broad_phase;
  broad_phase.reset(scene.surface, filter);
  ThreadPool one(1), three(3);
  size_t point_pairs = 0;
  for (int round = 0; round < 12; ++round) {
    std::vector<double> inflation(scene.group_count);
    for (double& r : inflation) r = random.uniform(0.0, round < 6 ? 0.03 : 0.1);
    std::vector<Vec3> x0 = scene.x, x1 = scene.x;
    // Far from the origin in some rounds: boxes are single precision about the scene.
    const Vec3 shift = round % 3 == 2 ? Vec3{1e4, -2e4, 5e3} : Vec3{};
    for (size_t v = 0; v < x0.size(); ++v) {
      x0[v] = x0[v] + shift + random.point() * (0.02 * round);
      x1[v] = x0[v] + random.point() * (round % 2 ? 0.05 : 0.0);
    }
    CandidateList list, again;
    broad_phase.find_swept(x0, x1, inflation, one, list);
    broad_phase.find_swept(x0, x1, inflation, three, again);
    CHECK(list == again);
    BroadPhase fresh;
    fresh.reset(scene.surface, filter);
    fresh.find_swept(x0, x1, inflation, three, again);
    CHECK(list == again);
    // Single precision about a scene of a few metres: boxes are at most 1e-6 too large, and never too small.
    CHECK(includes(list, brute_force(scene, filter, x0, x1, inflation, 0.0)));
    CHECK(includes(brute_force(scene, filter, x0, x1, inflation, -2e-6), list));
    CHECK(list[PairKind::PointTriangle].size() > 500);
    CHECK(list[PairKind::EdgeEdge].size() > 1000);
    CHECK(list[PairKind::PointEdge].size() > 30);
    point_pairs += list[PairKind::PointPoint].size();
    if (round % 2 == 0) {
      // At rest boxes are smaller by the rounding of displacements, which hardly ever decides.
      broad_phase.find(x0, inflation, one, again);
      CHECK(includes(list, again));
      CHECK(includes(again, brute_force(scene, filter, x0, x0, inflation, 0.0)));
      for (size_t kind = 0; kind < list.lists.size(); ++kind)
        CHECK(list.lists[kind].size() <= again.lists[kind].size() + 1);
    }
  }
  CHECK(point_pairs > 0);
}

// A floor of two triangles under spheres of fine meshes that move through it and along it, tilted in any way.
TEST_CASE("a tilted floor meets what comes near it, and little of what is in its box only") {
  RandomPoints random(34);
  ThreadPool pool(2);
  for (int round = 0; round < 8; ++round) {
    SceneBuilder scene;
    const std::vector<Vec3> corners = [&] {
      const Vec3 normal = normalized(random.point()), u = normalized(cross(normal, random.point()));
      const Vec3 v = cross(normal, u);
      return std::vector<Vec3>{(u + v) * -2.0, (u - v) * 2.0, (u + v) * 2.0, (v - u) * 2.0};
    }();
    scene.add_mesh({corners, {{0, 1, 2}, {0, 2, 3}}});
    const Vec3 normal = normalized(cross(corners[1] - corners[0], corners[2] - corners[0]));
    const TriangleMesh sphere = make_icosphere(0.2, 3);
    for (int k = 0; k < 4; ++k) scene.add_mesh(sphere, normal * 0.21 + corners[1] * (0.2 * k));
    std::vector<Vec3> x1 = scene.x;
    for (size_t v = 4; v < x1.size(); ++v)
      x1[v] += normal * (scene.surface.vertex_group[v] == 1 ? -0.5 : 0.0) + corners[2] * 0.02;
    const std::vector<double> inflation(5, 0.006);
    BroadPhase broad_phase;
    broad_phase.reset(scene.surface, PairFilter(5, true, false));
    CandidateList list;
    broad_phase.find_swept(scene.x, x1, inflation, pool, list);
    const auto& found = list[PairKind::PointTriangle];
    int64_t of_floor = 0;
    for (const PrimitivePair& pair : found) of_floor += pair.second < 2 && pair.first >= 4 ? 1 : 0;
    CHECK(of_floor < 2 * 2 * 642);  // the sphere that falls through it and the ends of the others
    for (const double t : {0.0, 0.25, 0.5, 0.75, 1.0}) {
      for (int32_t v = 4; v < scene.surface.vertex_count; ++v) {
        const Vec3 p = scene.x[v] + (x1[v] - scene.x[v]) * t;
        for (int32_t triangle = 0; triangle < 2; ++triangle) {
          const Index3& ids = scene.surface.triangles[triangle];
          if (point_triangle_squared_distance(p, corners[ids[0]], corners[ids[1]], corners[ids[2]]) >
              0.012 * 0.012)
            continue;
          CHECK(std::ranges::binary_search(found, PrimitivePair{v, triangle}));
        }
      }
    }
  }
}

// A funnel of slender triangles, whose boxes hold most of what is in it, with more of them than the sphere
// has.
TEST_CASE(
    "slender triangles of a large mesh meet what comes near them, and nothing that is in their boxes only") {
  TriangleMesh funnel;
  constexpr int kSides = 240;
  for (const auto& [radius, z] : {std::pair{0.05, 0.0}, {0.014, -0.06}})
    for (int k = 0; k < kSides; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / kSides;
      funnel.vertices.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
    }
  for (int k = 0; k < kSides; ++k) {
    const int next = (k + 1) % kSides;
    funnel.triangles.push_back({k, kSides + k, next});
    funnel.triangles.push_back({next, kSides + k, kSides + next});
  }
  ThreadPool pool(1);
  const std::vector<double> inflation = {0.001, 0.001};
  for (const double x : {0.02, 0.03}) {  // 10 mm and 2 mm from the wall
    SceneBuilder scene;
    scene.add_mesh(funnel);
    scene.add_mesh(make_icosphere(0.005, 1), {x, 0, -0.02});
    std::vector<Vec3> x1 = scene.x;
    for (int32_t v = 2 * kSides; v < scene.surface.vertex_count; ++v) x1[v] += Vec3{1e-4, 0, -1e-4};
    BroadPhase broad_phase;
    broad_phase.reset(scene.surface, PairFilter(2, true, false));
    CandidateList swept, still;
    broad_phase.find_swept(scene.x, x1, inflation, pool, swept);
    broad_phase.find(scene.x, inflation, pool, still);
    for (const CandidateList* list : {&swept, &still}) {
      const auto& found = (*list)[PairKind::PointTriangle];
      CHECK(found.empty() == (x == 0.02));
      for (int32_t v = 2 * kSides; v < scene.surface.vertex_count; ++v)
        for (int32_t t = 0; t < 2 * kSides; ++t) {
          const auto [a, b, c] = scene.surface.triangles[t];
          if (point_triangle_squared_distance(scene.x[v], scene.x[a], scene.x[b], scene.x[c]) < 4e-6)
            CHECK(std::ranges::binary_search(found, PrimitivePair{v, t}));
        }
    }
  }
}

TEST_CASE("what moves along together finds no more pairs than at rest; what crosses it is found") {
  SceneBuilder scene;
  scene.add_mesh(make_grid(1.0, 1.0, 20, 20));
  scene.add_mesh(make_grid(1.0, 1.0, 20, 20), {0, 0, 0.5});
  scene.add_particles({{0.3, 0.2, -3.0}, {9.0, 0.0, 0.0}});
  BroadPhase broad_phase;
  broad_phase.reset(scene.surface, PairFilter(scene.group_count));
  ThreadPool pool(1);
  const std::vector<double> inflation(scene.group_count, 0.001);
  CandidateList still, swept;
  broad_phase.find(scene.x, inflation, pool, still);
  const auto angle = 0.3;  // a turn by many cells, and a fall
  std::vector<Vec3> x1 = scene.x;
  for (Vec3& x : x1) {
    x = {std::cos(angle) * x.x - std::sin(angle) * x.y, std::sin(angle) * x.x + std::cos(angle) * x.y,
         x.z - 2.0};
  }
  x1[x1.size() - 2] = {0.3, 0.2, 3.0};
  broad_phase.find_swept(scene.x, x1, inflation, pool, swept);
  CHECK(swept[PairKind::EdgeEdge].size() < 2 * still[PairKind::EdgeEdge].size());
  CHECK(includes(swept, still));
  const auto point = static_cast<int32_t>(x1.size()) - 2;
  const auto found = std::ranges::count_if(swept[PairKind::PointTriangle],
                                           [&](const PrimitivePair& pair) { return pair.first == point; });
  CHECK(found >= 2);  // one triangle of each grid at least
}

TEST_CASE("points of all kinds meet edges without triangles, except those of the same rod nearby") {
  SceneBuilder scene;
  scene.add_mesh({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}});         // points 0 to 2, edges 0 to 2
  scene.add_rod({{0, 0, 0.1}, {1, 0, 0.1}});                                // points 3, 4, edge 3
  scene.add_rod({{0, 0, 0.2}, {0.3, 0, 0.2}, {0.6, 0, 0.2}, {1, 0, 0.2}});  // points 5 to 8, edges 4 to 6
  scene.add_particles({{0.5, 0, 0.15}});                                    // point 9
  PairFilter filter(4);
  filter.set_neighbours(5, 6);
  filter.set_neighbours(5, 7);
  BroadPhase broad_phase;
  broad_phase.reset(scene.surface, filter);
  ThreadPool pool(1);
  CandidateList list;
  broad_phase.find(scene.x, std::vector<double>(4, 1.0), pool, list);
  std::set<Index2> pairs;
  for (const PrimitivePair& pair : list[PairKind::PointEdge]) pairs.insert({pair.first, pair.second});
  std::set<Index2> expected;
  for (const int32_t edge : {3, 4, 5, 6})
    for (int32_t v = 0; v <= 9; ++v) {
      const Index2& ends = scene.surface.edges[edge];
      if (v != ends[0] && v != ends[1]) expected.insert({v, edge});
    }
  // 5 from the edges at 7 and 7 from the one at 5; those at 6 share a vertex with it or end at 7.
  for (const Index2& pair : {Index2{5, 5}, Index2{5, 6}, Index2{7, 4}}) expected.erase(pair);
  CHECK(pairs == expected);
  // So is the edge at 7 from the first of its rod, but not from the other rod.
  std::set<Index2> edges;
  for (const PrimitivePair& pair : list[PairKind::EdgeEdge]) edges.insert({pair.first, pair.second});
  CHECK_FALSE(edges.contains({4, 6}));
  CHECK(edges.contains({3, 6}));
}

TEST_CASE("a list built with a motion budget stays complete while vertices move within it, and not beyond") {
  RandomPoints random(32);
  SceneBuilder scene;
  scene.add_mesh(make_grid(1.0, 1.0, 20, 20));
  scene.add_mesh(make_grid(1.0, 1.0, 17, 13), {0.01, 0.02, 0.05});
  const PairFilter filter(2);
  BroadPhase broad_phase;
  broad_phase.reset(scene.surface, filter);
  ThreadPool pool(1);
  const double reach = 0.01, budget = 0.02;
  CandidateList list;
  broad_phase.find(scene.x, std::vector<double>(2, 0.5 * reach + budget), pool, list);
  const auto missing = [&](double motion) {
    std::vector<Vec3> x = scene.x;
    for (Vec3& v : x) v += normalized(random.point()) * motion;
    int count = 0;
    const SurfaceMesh& mesh = scene.surface;
    for (int32_t v = 0; v < mesh.vertex_count; ++v) {
      for (int32_t t = 0; t < static_cast<int32_t>(mesh.triangles.size()); ++t) {
        const Index3& ids = mesh.triangles[t];
        if (ids[0] == v || ids[1] == v || ids[2] == v) continue;
        if (point_triangle_squared_distance(x[v], x[ids[0]], x[ids[1]], x[ids[2]]) > reach * reach) continue;
        const PrimitivePair pair{v, t};
        count += std::find(list[PairKind::PointTriangle].begin(), list[PairKind::PointTriangle].end(),
                           pair) == list[PairKind::PointTriangle].end();
      }
    }
    return count;
  };
  for (int round = 0; round < 3; ++round) CHECK(missing(budget) == 0);
  CHECK(missing(10 * budget) > 0);
}

TEST_CASE("of what has moved all pairs are found, and no others") {
  RandomPoints random(35);
  SceneBuilder scene = mixed_scene(random);
  const PairFilter filter(scene.group_count);
  const std::vector<double> inflation(scene.group_count, 0.04);
  ThreadPool pool(2);
  BroadPhase broad_phase;
  broad_phase.reset(scene.surface, filter);
  const int32_t count = scene.surface.vertex_count;
  for (int round = 0; round < 9; ++round) {
    std::vector<Vec3> x0 = scene.x, x1 = scene.x;
    for (size_t v = 0; v < x0.size(); ++v) x1[v] += random.point() * 0.03;
    // None, single vertices, a body, a region of several bodies, more and more at random, all.
    std::vector<uint8_t> moved(count, 0);
    for (int32_t v = 0; v < count; ++v) {
      const bool is_near = norm(scene.x[v]) < 0.3;
      moved[v] = round == 1   ? v == 70 || v == count - 3
                 : round == 2 ? scene.surface.vertex_group[v] == 0
                 : round == 3 ? is_near
                              : round > 3 && random.uniform(0.0, 1.0) < (round - 3) * 0.2;
    }
    const auto check = [&](const auto& find) {
      CandidateList expected, list;
      find(expected, std::span<const uint8_t>{});
      find(list, std::span<const uint8_t>{moved});
      int64_t all = 0;
      for_each_pair_kind([&](auto kind) {
        all += expected[kind].size();
        std::erase_if(expected[kind], [&](const PrimitivePair& pair) {
          return std::ranges::none_of(PairRow<kind.value>::vertices(scene.surface, pair),
                                      [&](int32_t v) { return moved[v] != 0; });
        });
      });
      CHECK(list == expected);
      if (round == 0) CHECK(list.size() == 0);
      if (round > 0) CHECK(list.size() > 0);
      if (round == 8) CHECK(list.size() == all);
      if (round < 4) CHECK(list.size() < all);
    };
    check([&](CandidateList& out, std::span<const uint8_t> marks) {
      broad_phase.find(x0, inflation, pool, out, marks);
    });
    check([&](CandidateList& out, std::span<const uint8_t> marks) {
      broad_phase.find_swept(x0, x1, inflation, pool, out, marks);
    });
  }
  CandidateList list;
  CHECK_THROWS_AS(broad_phase.find(scene.x, inflation, pool, list, std::vector<uint8_t>(3, 1)),
                  InvalidArgument);
}

TEST_CASE("degraded trees are rebuilt without changing the result") {
  RandomPoints random(33);
  SceneBuilder scene;
  std::vector<Vec3> particles;
  for (int k = 0; k < 600; ++k) particles.push_back(random.point());
  scene.add_particles(particles);
  const PairFilter filter(1);
  BroadPhase broad_phase, fresh;
  broad_phase.reset(scene.surface, filter);
  ThreadPool pool(1);
  CandidateList list, expected;
  broad_phase.find(scene.x, std::vector<double>{0.02}, pool, list);
  for (Vec3& v : scene.x) v = random.point();
  broad_phase.find(scene.x, std::vector<double>{0.02}, pool, list);
  fresh.reset(scene.surface, filter);
  fresh.find(scene.x, std::vector<double>{0.02}, pool, expected);
  CHECK(list == expected);
  CHECK(list[PairKind::PointPoint].size() > 0);
  CHECK(includes(list, brute_force(scene, filter, scene.x, scene.x, {0.02}, 0.0)));
}

TEST_CASE("empty scenes, empty groups and bad meshes") {
  BroadPhase broad_phase;
  ThreadPool pool(1);
  CandidateList list;
  list[PairKind::PointTriangle].push_back({1, 2});
  broad_phase.reset({}, PairFilter(0));
  broad_phase.find({}, {}, pool, list);
  CHECK(list.size() == 0);

  SceneBuilder scene;
  scene.add_particles({});
  scene.add_mesh(make_box({1, 1, 1}));
  scene.add_mesh(make_box({1, 1, 1}), {1.05, 0, 0});
  broad_phase.reset(scene.surface, PairFilter(3, true, false));
  broad_phase.find(scene.x, std::vector<double>(3, 0.01), pool, list);
  CHECK(list.size() == 0);
  broad_phase.find(scene.x, std::vector<double>(3, 0.03), pool, list);
  CHECK(list.size() > 0);
  CHECK_THROWS_AS(broad_phase.find(scene.x, std::vector<double>(2, 0.03), pool, list), InvalidArgument);
  CHECK_THROWS_AS(broad_phase.find({}, std::vector<double>(3, 0.03), pool, list), InvalidArgument);
  CHECK_THROWS_AS(broad_phase.set_filter(PairFilter(2)), InvalidArgument);

  SurfaceMesh bad = scene.surface;
  bad.triangles[0][1] = bad.vertex_count;
  CHECK_THROWS_AS(broad_phase.reset(bad, PairFilter(3)), InvalidMesh);
  bad = scene.surface;
  bad.edge_group[0] = 2;
  CHECK_THROWS_AS(broad_phase.reset(bad, PairFilter(3)), InvalidMesh);
  CHECK_THROWS_AS(broad_phase.reset(scene.surface, PairFilter(2)), InvalidMesh);
}
