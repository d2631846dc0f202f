// Step bound of whole scenes: bullets, random steps without intersections, and the minimum of single calls.
#include <doctest/doctest.h>

#include <algorithm>

#include <stark/base/error.h>
#include <stark/collision/broad_phase.h>
#include <stark/collision/intersection.h>
#include <stark/collision/max_safe_step.h>
#include <stark/geometry/shapes.h>

#include "support/collision_scenes.h"
#include "support/random_points.h"

using namespace stark;
using test::RandomPoints;
using test::SceneBuilder;

TEST_CASE("bullets at 1e4 m/s through a sheet of 1e-4 m never pass, in any orientation") {
  RandomPoints random(47);
  const double h = 1.0 / 30.0;
  for (int round = 0; round < 300; ++round) {
    SceneBuilder scene;
    const int32_t sheet = scene.add_mesh(make_box({1.0, 1.0, 1e-4}, 8));
    const Vec3 start{random.uniform(-0.45, 0.45), random.uniform(-0.45, 0.45), random.uniform(0.02, 2.0)};
    const int32_t bullet =
        round % 3 == 2 ? scene.add_particles({start}) : scene.add_mesh(make_box({0.01, 0.01, 0.01}), start);
    std::vector<Vec3> x1 = scene.x;
    // Aimed at a point of the sheet, 1e4 m/s.
    const Vec3 aim{random.uniform(-0.45, 0.45), random.uniform(-0.45, 0.45), 0.0};
    const Vec3 velocity = normalized(aim - start) * 1e4;
    for (int32_t v = 0; v < scene.surface.vertex_count; ++v) {
      if (scene.surface.vertex_group[v] == bullet) x1[v] += velocity * h;
    }
    BroadPhase broad_phase;
    broad_phase.reset(scene.surface, PairFilter(2, true, false));
    ThreadPool pool(1);
    CandidateList list;
    const double xi = 1e-6;
    broad_phase.find_swept(scene.x, x1, std::vector<double>(2, xi), pool, list);
    CcdReport report;
    const double t = max_safe_step(scene.surface, list, scene.x, x1, xi, pool, &report);
    const double hit = norm(aim - start) / norm(velocity * h);
    REQUIRE(t < hit);
    // A tenth of the time is given back; the corners of the bullet lead it by at most 1 cm in height.
    CAPTURE(hit);
    REQUIRE(t > 0.89 * hit - 0.01 / std::fabs(velocity.z * h));
    REQUIRE(report.kind.has_value());
    std::vector<Vec3> x = scene.x;
    for (size_t v = 0; v < x.size(); ++v) x[v] += (x1[v] - x[v]) * t;
    REQUIRE(find_intersections(scene.surface, x, PairFilter(2, true, false), pool).empty());
    (void)sheet;
  }
}

TEST_CASE("iterated random steps with CCD never intersect; without they do") {
  RandomPoints random(48);
  SceneBuilder scene;
  scene.add_mesh(make_grid(0.5, 0.5, 8, 8), {0, 0, 0.05});
  scene.add_mesh(make_grid(0.5, 0.5, 7, 9), {0.01, 0.02, 0.10});
  scene.add_mesh(make_icosphere(0.15, 1), {0, 0, -0.14});
  scene.add_rod({{-0.4, 0.013, 0.017}, {-0.2, 0.011, 0.02}, {0.1, 0.017, 0.026}, {0.4, 0.01, 0.021}});
  scene.add_mesh(make_grid(4.0, 4.0, 1, 1), {0, 0, -0.3});
  PairFilter filter(5);
  filter.set(2, 2, false);
  BroadPhase broad_phase;
  broad_phase.reset(scene.surface, filter);
  ThreadPool pool(2);
  const std::vector<double> xi(5, 5e-6);
  std::vector<Vec3> x = scene.x;
  CandidateList list;
  REQUIRE(find_intersections(scene.surface, x, filter, pool).empty());
  int cut = 0, naive = 0;
  for (int step = 0; step < 200; ++step) {
    std::vector<Vec3> x1 = x;
    const double size = std::pow(10.0, random.uniform(-3.0, -0.5));
    for (Vec3& v : x1) v += random.point() * size;
    for (int32_t v = 0; v < scene.surface.vertex_count; ++v) {
      if (scene.surface.vertex_group[v] == 4) x1[v] = x[v];
    }
    broad_phase.find_swept(x, x1, xi, pool, list);
    const double t = max_safe_step(scene.surface, list, x, x1, {xi}, pool);
    REQUIRE(t > 0.0);
    cut += t < 1.0;
    naive += !find_intersections(scene.surface, x1, filter, pool).empty();
    for (size_t v = 0; v < x.size(); ++v) x[v] += (x1[v] - x[v]) * t;
    REQUIRE(find_intersections(scene.surface, x, filter, pool).empty());
  }
  CHECK(cut > 100);
  CHECK(naive > 100);
}

TEST_CASE("batch: the minimum of single calls, same bits for any thread count, names the limiting pair") {
  RandomPoints random(49);
  SceneBuilder scene;
  scene.add_mesh(make_grid(1.0, 1.0, 30, 30));
  scene.add_mesh(make_grid(1.0, 1.0, 29, 31), {0.01, 0.02, 0.05});
  std::vector<Vec3> x1 = scene.x;
  for (Vec3& v : x1) v += random.point() * 0.02;
  for (int32_t v = 0; v < scene.surface.vertex_count; ++v)
    x1[v].z += scene.surface.vertex_group[v] == 0 ? 0.05 : -0.05;
  BroadPhase broad_phase;
  const SurfaceMesh& mesh = scene.surface;
  broad_phase.reset(mesh, PairFilter(2));
  ThreadPool one(1), three(3);
  CandidateList list;
  const std::vector<double> xi = {1e-4, 2e-4};
  broad_phase.find_swept(scene.x, x1, xi, one, list);
  CcdReport a, b;
  const double t = max_safe_step(mesh, list, scene.x, x1, {xi}, one, &a);
  CHECK(t == max_safe_step(mesh, list, scene.x, x1, {xi}, three, &b));
  CHECK(a.kind == b.kind);
  CHECK(a.candidate == b.candidate);
  CHECK(a.tested == b.tested);
  CHECK(t < 1.0);
  double smallest = 1.0;
  const auto separation = [&](int32_t g, int32_t h) { return xi[g] + xi[h]; };
  for (const auto& [p, triangle] : list[PairKind::PointTriangle]) {
    const Index3& i = mesh.triangles[triangle];
    smallest = std::min(smallest,
                        point_triangle_ccd({scene.x[p], scene.x[i[0]], scene.x[i[1]], scene.x[i[2]]},
                                           {x1[p], x1[i[0]], x1[i[1]], x1[i[2]]},
                                           separation(mesh.vertex_group[p], mesh.triangle_group[triangle])));
  }
  for (const auto& [e, f] : list[PairKind::EdgeEdge]) {
    const Index2 &i = mesh.edges[e], &j = mesh.edges[f];
    smallest = std::min(smallest, edge_edge_ccd({scene.x[i[0]], scene.x[i[1]], scene.x[j[0]], scene.x[j[1]]},
                                                {x1[i[0]], x1[i[1]], x1[j[0]], x1[j[1]]},
                                                separation(mesh.edge_group[e], mesh.edge_group[f])));
  }
  CHECK(t == smallest);
  CHECK_THROWS_AS(max_safe_step(mesh, list, {}, x1, {xi}, one), InvalidArgument);
}

TEST_CASE("what has come to its separation may go on to the wall of a core") {
  SceneBuilder scene;
  scene.add_mesh(make_grid(1.0, 1.0, 1, 1));
  scene.add_mesh(make_icosphere(0.1, 0), {0.1, 0.05, 0.3});
  std::vector<Vec3> x = scene.x, x1;
  const auto lowest = [&] {
    double z = HUGE_VAL;
    for (int32_t v = 0; v < scene.surface.vertex_count; ++v)
      if (scene.surface.vertex_group[v] == 1) z = std::min(z, x[v].z);
    return z;
  };
  const auto move = [&](double dz) {
    x1 = x;
    for (int32_t v = 0; v < scene.surface.vertex_count; ++v)
      if (scene.surface.vertex_group[v] == 1) x1[v].z += dz;
  };
  const std::vector<double> by_group = {0.005, 0.005};
  const std::vector<double> cores = {0.0, 1e-3};
  const double separation = 0.01, part = 0.999;
  const Separations plain{.by_group = by_group};
  const Separations core{.by_group = by_group, .core = cores, .core_part = part};
  BroadPhase broad_phase;
  broad_phase.reset(scene.surface, PairFilter(2));
  ThreadPool pool(1);
  CandidateList list;
  const auto fraction = [&](double gap, double motion, const Separations& separations) {
    move(gap - lowest());
    x = x1;
    move(-motion);
    broad_phase.find_swept(x, x1, by_group, pool, list);
    return max_safe_step(scene.surface, list, x, x1, separations, pool);
  };
  // From afar both keep the separation ...
  for (const Separations& separations : {plain, core})
    CHECK(fraction(1.1 * separation, 0.2 * separation, separations) == doctest::Approx(0.45).epsilon(1e-9));
  // ... from a millionth above it on, nine tenths of the way to the wall are free.
  const double gap = (1.0 + 1e-6) * separation, motion = 0.01 * separation;
  CHECK(fraction(gap, motion, plain) == doctest::Approx(0.9 * 1e-6 / 0.01).epsilon(1e-3));
  CHECK(fraction(gap, motion, core) == doctest::Approx(0.9 * (1.0 + 1e-6 - part) / 0.01).epsilon(1e-3));
}

TEST_CASE("two groups may keep a separation of their own") {
  const std::vector<double> by_group = {1.0, 2.0, 4.0};
  const std::vector<Separations::Pair> by_pair = {{0, 2, 0.5}, {1, 1, 0.25}};
  const Separations separations{by_group, by_pair};
  CHECK(separations(0, 2) == 0.5);
  CHECK(separations(2, 0) == 0.5);
  CHECK(separations(1, 1) == 0.25);
  CHECK(separations(0, 1) == 3.0);
  CHECK(separations(2, 2) == 8.0);
}

TEST_CASE("batch of four lanes: every number of candidates, every kind, agrees with single calls") {
  RandomPoints random(50);
  ThreadPool pool(1);
  int cut = 0;
  for (int round = 0; round < 3000; ++round) {
    const double motion = std::pow(10.0, random.uniform(-2.0, 0.5));
    SurfaceMesh mesh;
    std::vector<Vec3> x0, x1;
    CandidateList list;
    const int pairs = random.integer(1, 7), kind = round % 4;
    double expected = 1.0;
    const double xi = round % 3 ? 1e-3 : 0.0;
    for (int k = 0; k < pairs; ++k) {
      const int32_t v = mesh.vertex_count;
      mesh.vertex_count += 4;
      for (int i = 0; i < 4; ++i) {
        x0.push_back(random.point() + Vec3{100.0, 0, 0});
        x1.push_back(x0.back() + random.point() * motion);
      }
      mesh.triangles.push_back({v + 1, v + 2, v + 3});
      mesh.edges.push_back({v, v + 1});
      mesh.edges.push_back({v + 2, v + 3});
      const std::array<Vec3, 4> a = {x0[v], x0[v + 1], x0[v + 2], x0[v + 3]},
                                b = {x1[v], x1[v + 1], x1[v + 2], x1[v + 3]};
      double t = 1.0;
      if (kind == 0) {
        list[PairKind::PointTriangle].push_back({v, k});
        t = point_triangle_ccd(a, b, xi);
      } else if (kind == 1) {
        list[PairKind::EdgeEdge].push_back({2 * k, 2 * k + 1});
        t = edge_edge_ccd(a, b, xi);
      } else if (kind == 2) {
        list[PairKind::PointEdge].push_back({v, 2 * k + 1});
        t = point_edge_ccd({a[0], a[2], a[3]}, {b[0], b[2], b[3]}, xi);
      } else {
        list[PairKind::PointPoint].push_back({v, v + 1});
        t = point_point_ccd({a[0], a[1]}, {b[0], b[1]}, xi);
      }
      expected = std::min(expected, t);
    }
    mesh.vertex_group.assign(mesh.vertex_count, 0);
    mesh.edge_group.assign(mesh.edges.size(), 0);
    mesh.triangle_group.assign(mesh.triangles.size(), 0);
    cut += expected < 1.0;
    REQUIRE(max_safe_step(mesh, list, x0, x1, xi, pool) == expected);
  }
  CHECK(cut > 100);
}

TEST_CASE("one position that is not finite stops the whole step") {
  SceneBuilder scene;
  scene.add_mesh(make_grid(1.0, 1.0, 3, 3));
  scene.add_mesh(make_grid(1.0, 1.0, 3, 3), {0, 0, 0.5});
  BroadPhase broad_phase;
  broad_phase.reset(scene.surface, PairFilter(2, true, false));
  ThreadPool pool(1);
  CandidateList list;
  broad_phase.find(scene.x, std::vector<double>(2, 0.3), pool, list);
  CHECK(max_safe_step(scene.surface, list, scene.x, scene.x, 0.0, pool) == 1.0);
  for (const double bad : {double(NAN), double(INFINITY), -double(INFINITY)}) {
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<Vec3> x1 = scene.x;
      x1[20][axis] = bad;
      CHECK(max_safe_step(scene.surface, list, scene.x, x1, 0.0, pool) == 0.0);
    }
  }
}
