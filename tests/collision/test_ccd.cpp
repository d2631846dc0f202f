// Conservative advancement against closed forms and dense sampling of the motion.
#include <doctest/doctest.h>

#include <algorithm>

#include <stark/collision/ccd.h>
#include <stark/geometry/distance.h>

#include "support/random_points.h"

using namespace stark;
using test::RandomPoints;

namespace {

template <size_t N>
std::array<Vec3, N> lerp(const std::array<Vec3, N>& a, const std::array<Vec3, N>& b, double t) {
  std::array<Vec3, N> x;
  for (size_t k = 0; k < N; ++k) x[k] = a[k] + (b[k] - a[k]) * t;
  return x;
}

double pt_distance(const std::array<Vec3, 4>& x) {
  return std::sqrt(point_triangle_squared_distance(x[0], x[1], x[2], x[3]));
}
double ee_distance(const std::array<Vec3, 4>& x) {
  return std::sqrt(edge_edge_squared_distance(x[0], x[1], x[2], x[3]));
}
double pe_distance(const std::array<Vec3, 3>& x) {
  return std::sqrt(point_edge_squared_distance(x[0], x[1], x[2]));
}
double pp_distance(const std::array<Vec3, 2>& x) { return norm(x[0] - x[1]); }

// Smallest distance on [0, t] over samples.
template <size_t N, typename Distance>
double sampled_minimum(const std::array<Vec3, N>& a, const std::array<Vec3, N>& b, double t,
                       Distance&& distance) {
  double smallest = HUGE_VAL;
  constexpr int kSamples = 200;
  for (int k = 0; k <= kSamples; ++k) smallest = std::min(smallest, distance(lerp(a, b, t * k / kSamples)));
  return smallest;
}

// Random motions of all sizes; checks the promise of the header and returns how many steps were cut short.
template <size_t N, typename Ccd, typename Distance>
int check_random_motions(unsigned seed, Ccd&& ccd, Distance&& distance) {
  RandomPoints random(seed);
  int cut = 0;
  for (int round = 0; round < 20000; ++round) {
    std::array<Vec3, N> a, b;
    const double motion = std::pow(10.0, random.uniform(-3.0, 1.0));
    const Vec3 shift = round % 4 == 0 ? random.point() * 1e3 : Vec3{}, common = random.point() * 10.0;
    for (size_t k = 0; k < N; ++k) {
      a[k] = (round % 5 == 0 ? random.lattice() * 0.5 : random.point()) + shift;
      b[k] = a[k] + common + random.point() * motion;
    }
    const double xi = round % 2 ? std::pow(10.0, random.uniform(-6.0, -1.0)) : 0.0;
    const double d0 = distance(a);
    const double t = ccd(a, b, xi);
    REQUIRE(t >= 0.0);
    REQUIRE(t <= 1.0);
    cut += t < 1.0;
    // Below the rounding error of the input a distance counts as zero.
    if (d0 < 1e-12) {
      REQUIRE((t == 0.0 || d0 > 0.0));
      continue;
    }
    REQUIRE(t > 0.0);
    const double separation = d0 > xi ? xi : 0.5 * d0;
    // Samples carry the rounding of shifted coordinates, at most 1e-12 here.
    REQUIRE(sampled_minimum(a, b, t, distance) > separation - 1e-12);
  }
  return cut;
}

}  // namespace

TEST_CASE("the distance on the way stays above the separation for random motions") {
  CHECK(check_random_motions<2>(
            41, [](auto& a, auto& b, double xi) { return point_point_ccd(a, b, xi); }, pp_distance) > 5);
  CHECK(check_random_motions<3>(
            42, [](auto& a, auto& b, double xi) { return point_edge_ccd(a, b, xi); }, pe_distance) > 50);
  CHECK(check_random_motions<4>(
            43, [](auto& a, auto& b, double xi) { return point_triangle_ccd(a, b, xi); }, pt_distance) > 300);
  CHECK(check_random_motions<4>(
            44, [](auto& a, auto& b, double xi) { return edge_edge_ccd(a, b, xi); }, ee_distance) > 500);
}

TEST_CASE("head-on translation: closed form") {
  // Gap 1, separation 0.01, a tenth of the time given back.
  const std::array<Vec3, 4> a = {Vec3{0.2, 0.2, 1.0}, Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}};
  for (const double speed : {1.0, 2.0, 1e3, 1e9}) {
    std::array<Vec3, 4> b = a;
    b[0].z -= speed;
    const double t = point_triangle_ccd(a, b, 0.01);
    CHECK(t == doctest::Approx(0.9 * (1.0 - 0.01) / speed).epsilon(1e-12));
  }
  std::array<Vec3, 4> away = a;
  away[0].z += 5.0;
  CHECK(point_triangle_ccd(a, away, 0.01) == 1.0);
  CHECK(point_triangle_ccd(a, a, 0.01) == 1.0);
  const std::array<Vec3, 4> cross0 = {Vec3{-1, 0, 0}, Vec3{1, 0, 0}, Vec3{0, -1, 1}, Vec3{0, 1, 1}};
  std::array<Vec3, 4> cross1 = cross0;
  cross1[2].z = cross1[3].z = -1.0;
  CHECK(edge_edge_ccd(cross0, cross1, 0.0) == doctest::Approx(0.45).epsilon(1e-12));
  CHECK(point_point_ccd({Vec3{0, 0, 0}, Vec3{1, 0, 0}}, {Vec3{1, 0, 0}, Vec3{0, 0, 0}}, 0.0) ==
        doctest::Approx(0.45).epsilon(1e-12));
}

TEST_CASE("a pair that is pushed again and again never comes nearer than the separation") {
  // The point is pushed through the triangle, the edge through the edge; rounding must not wear the gap down.
  for (const double far : {0.0, 1e3}) {
    CAPTURE(far);
    const double xi = 2e-6;
    const Vec3 shift{far, -far, 2.0 * far};
    std::array<Vec3, 4> point = {Vec3{0.2, 0.2, 1e-3}, Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}};
    std::array<Vec3, 4> edges = {Vec3{-1, 0, 1e-3}, Vec3{1, 0, 1e-3}, Vec3{0, -1, 0}, Vec3{0, 1, 0}};
    for (int k = 0; k < 4; ++k) point[k] += shift, edges[k] += shift;
    for (int push = 0; push < 300; ++push) {
      std::array<Vec3, 4> p = point, e = edges;
      p[0].z -= 0.01 + 1e-3 * push;
      e[0].z -= 0.01, e[1].z -= 0.01;
      point = lerp(point, p, point_triangle_ccd(point, p, xi));
      edges = lerp(edges, e, edge_edge_ccd(edges, e, xi));
    }
    const double rounding = 1e-15 + 4e-16 * far;
    CHECK(pt_distance(point) > xi - rounding);
    CHECK(ee_distance(edges) > xi - rounding);
    CHECK(pt_distance(point) < 1.1 * xi);
  }
}

TEST_CASE("pairs that start nearer than the separation keep half of their gap") {
  const std::array<Vec3, 4> a = {Vec3{0.2, 0.2, 1e-6}, Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}};
  std::array<Vec3, 4> b = a;
  b[0].z = -1.0;
  CHECK(point_triangle_ccd(a, b, 1e-3) == doctest::Approx(0.9 * 0.5e-6).epsilon(1e-5));
  b[0].z = 1.0;
  CHECK(point_triangle_ccd(a, b, 1e-3) == 1.0);
}

TEST_CASE("sliding at a small gap does not limit the step") {
  const std::array<Vec3, 4> a = {Vec3{0.2, 0.2, 1e-6}, Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}};
  std::array<Vec3, 4> b = a;
  b[0].x += 100.0;
  CHECK(point_triangle_ccd(a, b, 1e-7) == 1.0);
}

TEST_CASE("turning edges: the step ends before the crossing, and uses most of the time to it") {
  RandomPoints random(45);
  int collisions = 0, half = 0;
  for (int round = 0; round < 5000; ++round) {
    std::array<Vec3, 4> a, b;
    for (int k = 0; k < 4; ++k) {
      a[k] = random.point();
      b[k] = random.point();
    }
    // Edges cross where the signed volume changes sign while the closest points are inside both.
    double touch = 2.0, last = 0.0;
    constexpr int kSamples = 1000;
    for (int k = 0; k <= kSamples && touch > 1.0; ++k) {
      const auto x = lerp(a, b, double(k) / kSamples);
      const bool inside = edge_edge_type(x[0], x[1], x[2], x[3]) == EdgeEdgeType::EA_EB;
      const double volume = inside ? dot(x[2] - x[0], cross(x[1] - x[0], x[3] - x[2])) : 0.0;
      if (volume * last < 0.0) touch = double(k) / kSamples;
      last = volume;
    }
    const double t = edge_edge_ccd(a, b, 0.0);
    if (touch <= 1.0) {
      ++collisions;
      REQUIRE(t < touch);
      half += t > 0.5 * touch;
    }
  }
  CHECK(collisions > 100);
  CHECK(half > 0.95 * collisions);
}

TEST_CASE("touching and degenerate starts return zero or make progress, never a wrong pass") {
  const Vec3 o{}, e{1, 0, 0};
  CHECK(point_triangle_ccd({o, o, e, Vec3{0, 1, 0}}, {Vec3{0, 0, -1}, o, e, Vec3{0, 1, 0}}, 0.0) == 0.0);
  // A triangle without area is a segment.
  const double t = point_triangle_ccd({Vec3{0.5, 0, 1}, o, e, Vec3{0.5, 0, 0}},
                                      {Vec3{0.5, 0, -1}, o, e, Vec3{0.5, 0, 0}}, 0.0);
  CHECK(t == doctest::Approx(0.45).epsilon(1e-9));
  // Parallel edges.
  CHECK(edge_edge_ccd({o, e, Vec3{0, 0, 1}, Vec3{1, 0, 1}}, {o, e, Vec3{0, 0, -1}, Vec3{1, 0, -1}}, 0.0) ==
        doctest::Approx(0.45).epsilon(1e-9));
  // Edges of zero length are points.
  CHECK(edge_edge_ccd({o, o, Vec3{0, 0, 1}, Vec3{0, 0, 1}}, {o, o, Vec3{0, 0, -1}, Vec3{0, 0, -1}}, 0.0) ==
        doctest::Approx(0.45).epsilon(1e-9));
}

TEST_CASE("edges that stay parallel and in one plane do not pass through each other") {
  RandomPoints random(47);
  for (int round = 0; round < 4000; ++round) {
    // Edge B comes at edge A along n and slides along both; every other round it starts end on end instead.
    const Vec3 u = normalized(random.point()), n = normalized(cross(u, random.point())),
               base = random.point();
    const double gap = std::pow(10.0, random.uniform(-8.0, 0.0)), way = gap * random.uniform(1.5, 20.0);
    const Vec3 apart = round % 2 ? n : u, shift = apart * -way + (round % 2 ? u * (0.3 * gap) : Vec3{});
    const Vec3 first = base + (round % 2 ? n * gap + u * random.uniform(-0.4, 0.4) : u * (1.0 + gap));
    const std::array<Vec3, 4> a = {base, base + u, first, first + u * random.uniform(0.5, 1.5)};
    const std::array<Vec3, 4> b = {base, base + u, a[2] + shift, a[3] + shift};
    const double t = edge_edge_ccd(a, b, 0.0);
    REQUIRE(t < gap / way);
    REQUIRE(t > 0.5 * gap / way);
    // So do ends against edges.
    const double end = std::min(point_edge_ccd({a[2], a[0], a[1]}, {b[2], b[0], b[1]}, 0.0),
                                point_edge_ccd({a[0], a[2], a[3]}, {b[0], b[2], b[3]}, 0.0));
    REQUIRE(end < gap / way);
  }
}

TEST_CASE("nearly degenerate stencils at tiny gaps still make progress and stay apart") {
  RandomPoints random(46);
  for (int round = 0; round < 20000; ++round) {
    const double gap = std::pow(10.0, random.uniform(-9.0, -3.0)),
                 thin = std::pow(10.0, random.uniform(-12.0, 0.0));
    const Vec3 n = normalized(random.point()), u = normalized(cross(n, random.point())), v = cross(n, u);
    const Vec3 base = random.point();
    // Nearly parallel edges, or a needle, at distance about `gap` along n.
    std::array<Vec3, 4> a, b;
    double d0, t;
    if (round % 2) {
      a = {base, base + u, base + n * gap + u * random.uniform(-0.9, 0.9), Vec3{}};
      a[3] = a[2] + u * random.uniform(0.5, 1.5) + v * thin;
      for (int k = 0; k < 4; ++k) b[k] = a[k] + n * (k < 2 ? 1.0 : -1.0) + random.point() * 0.1;
      d0 = ee_distance(a);
      t = edge_edge_ccd(a, b, 0.0);
      REQUIRE(sampled_minimum(a, b, t, ee_distance) > 0.0);
    } else {
      a = {base + n * gap + u * random.uniform(0.0, 1.0), base, base + u,
           base + u * random.uniform(0.0, 1.0) + v * thin};
      for (int k = 0; k < 4; ++k) b[k] = a[k] + n * (k < 1 ? -1.0 : 1.0) + random.point() * 0.1;
      d0 = pt_distance(a);
      t = point_triangle_ccd(a, b, 0.0);
      REQUIRE(sampled_minimum(a, b, t, pt_distance) > 0.0);
    }
    REQUIRE(d0 > 0.0);
    // Closing speed is about 2, at most 3: at least a third of the 0.9 gap must be used.
    REQUIRE(t > 0.1 * d0);
  }
}

TEST_CASE("edges that slide past each other and turn at a small gap pass in one go") {
  // No plane separates the whole motion: the far ends swap sides by much more than the gap.
  const std::array<Vec3, 4> a = {Vec3{-1, 0, 1e-5}, Vec3{1, 0, 1e-5}, Vec3{0, -1, 0}, Vec3{0, 1, 0}};
  const std::array<Vec3, 4> b = {Vec3{-1, 0, 0.3}, Vec3{1, 0.2, -0.3 + 2e-5}, Vec3{0, -1, 0.01},
                                 Vec3{0, 1, -0.011}};
  REQUIRE(sampled_minimum(a, b, 1.0, ee_distance) > 5e-6);
  CHECK(edge_edge_ccd(a, b, 1e-6) == 1.0);
  // The same motion, but through the other edge.
  std::array<Vec3, 4> c = b;
  c[0].z -= 0.02;
  c[1].z -= 0.02;
  CHECK(edge_edge_ccd(a, c, 1e-6) < 0.01);
}

TEST_CASE("a triangle that tilts below a point at a large separation passes in one go") {
  // The point is hardly farther than the separation, which is a tenth of the size of the triangle. This turns
  // by 0.2 rad about a line in it, far from the point's foot on one side, and the point keeps ahead of it. A
  // plane that stands still is left after 1e-5 of the way, again and again.
  const double separation = 0.1, angle = 0.2, foot = 0.3;
  CcdSettings sharper;
  sharper.sharper_iterations = 128;
  for (const double above : {1e-3, 1e-5, 1e-7}) {
    const double d0 = separation * (1.0 + above);
    const std::array<Vec3, 4> x0 = {Vec3{foot, 0.0, d0}, Vec3{-1.0, -0.7, 0.0}, Vec3{1.0, -0.8, 0.0},
                                    Vec3{0.1, 1.0, 0.0}};
    const auto turned = [&](const Vec3& p) { return Vec3{p.x, p.y, p.z + std::tan(angle) * p.x}; };
    std::array<Vec3, 4> x1 = {x0[0], turned(x0[1]), turned(x0[2]), turned(x0[3])};
    x1[0].z = x0[0].z + std::tan(angle) * foot + 0.05 * separation;
    CHECK(sampled_minimum(x0, x1, 1.0, pt_distance) > separation);
    CHECK(point_triangle_ccd(x0, x1, separation) < 1.0);
    CHECK(point_triangle_ccd(x0, x1, separation, sharper) == 1.0);
    // Where it does not keep ahead, it comes to the separation.
    x1[0].z = x0[0].z + std::tan(angle) * foot - 0.05 * separation;
    const double t = point_triangle_ccd(x0, x1, separation, sharper);
    CHECK(t < 1.0);
    CHECK(sampled_minimum(x0, x1, t, pt_distance) > separation);
  }
}

TEST_CASE("settings: margin, horizon, iteration limit") {
  const std::array<Vec3, 2> a = {Vec3{0, 0, 0}, Vec3{1, 0, 0}}, b = {Vec3{2, 0, 0}, Vec3{1, 0, 0}};
  CcdSettings settings;
  settings.time_margin = 0.0;
  const double impact = point_point_ccd(a, b, 0.0, settings);
  CHECK(impact == doctest::Approx(0.5).epsilon(1e-12));
  CHECK(impact <= 0.5);
  settings.horizon = 0.4;
  CHECK(point_point_ccd(a, b, 0.0, settings) == 1.0);
  settings.horizon = 1.0;
  settings.max_iterations = 1;
  CHECK(point_point_ccd(a, b, 0.0, settings) <= 0.5);
}

TEST_CASE("positions that are not finite give no step") {
  const std::array<Vec3, 4> a = {Vec3{0.2, 0.2, 1.0}, Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}};
  for (const double bad : {double(NAN), double(INFINITY), -double(INFINITY)}) {
    for (int vertex = 0; vertex < 4; ++vertex) {
      for (int axis = 0; axis < 3; ++axis) {
        std::array<Vec3, 4> b = a;
        b[vertex][axis] = bad;
        CHECK(point_triangle_ccd(a, b, 0.0) == 0.0);
        CHECK(point_triangle_ccd(b, a, 0.0) == 0.0);
        CHECK(edge_edge_ccd(a, b, 0.0) == 0.0);
      }
    }
  }
}
