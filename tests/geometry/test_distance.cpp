// Distances and types against an independent oracle: minimum over all features (clamped projections),
// evaluated in extended precision.
#include <doctest/doctest.h>

#include <algorithm>

#include <stark/geometry/distance.h>

#include "support/random_points.h"

using namespace stark;
using test::RandomPoints;

namespace {

struct Long3 {
  long double x, y, z;
};
Long3 sub(const Vec3& a, const Vec3& b) {
  return {(long double)a.x - b.x, (long double)a.y - b.y, (long double)a.z - b.z};
}
long double dot(const Long3& a, const Long3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Long3 cross(const Long3& a, const Long3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

long double segment_distance2(const Vec3& p, const Vec3& e0, const Vec3& e1) {
  const Long3 e = sub(e1, e0), w = sub(p, e0);
  const long double length2 = dot(e, e);
  long double t = length2 > 0 ? dot(w, e) / length2 : 0;
  t = std::clamp<long double>(t, 0, 1);
  const Long3 r{w.x - t * e.x, w.y - t * e.y, w.z - t * e.z};
  return dot(r, r);
}

// A triangle's interior counts only if the projection lies inside: barycentric coordinates by normal
// equations.
long double triangle_distance2(const Vec3& p, const Vec3& t0, const Vec3& t1, const Vec3& t2) {
  long double best =
      std::min({segment_distance2(p, t0, t1), segment_distance2(p, t1, t2), segment_distance2(p, t2, t0)});
  const Long3 a = sub(t1, t0), b = sub(t2, t0), w = sub(p, t0);
  const long double aa = dot(a, a), ab = dot(a, b), bb = dot(b, b), wa = dot(w, a), wb = dot(w, b);
  const long double determinant = aa * bb - ab * ab;
  if (determinant > 0) {
    const long double u = (bb * wa - ab * wb) / determinant, v = (aa * wb - ab * wa) / determinant;
    if (u >= 0 && v >= 0 && u + v <= 1) {
      const Long3 n = cross(a, b);
      const long double h = dot(n, w);
      best = std::min(best, h * h / dot(n, n));
    }
  }
  return best;
}

long double edge_edge_distance2(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1) {
  long double best = std::min({segment_distance2(a0, b0, b1), segment_distance2(a1, b0, b1),
                               segment_distance2(b0, a0, a1), segment_distance2(b1, a0, a1)});
  // Parameters by the cross product: the normal equations lose all digits for nearly parallel lines.
  const Long3 u = sub(a1, a0), v = sub(b1, b0), w = sub(a0, b0), n = cross(u, v);
  const long double nn = dot(n, n);
  if (nn > 0) {
    const long double s = dot(cross(v, w), n) / nn, t = dot(cross(u, w), n) / nn;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) {
      const long double h = dot(n, w);
      best = std::min(best, h * h / nn);
    }
  }
  return best;
}

double weighted_distance2(const std::array<double, 4>& w, const Vec3& a0, const Vec3& a1, const Vec3& b0,
                          const Vec3& b1) {
  return squared_norm(a0 * w[0] + a1 * w[1] - b0 * w[2] - b1 * w[3]);
}

// Squared distances of configurations of size one carry an absolute rounding error of some eps |x| d + eps^2;
// near degenerate normals amplify it, for which sqrt(1e-20) is the threshold of the degenerate branch.
constexpr double kTolerance = 1e-13;

}  // namespace

TEST_CASE("point-triangle: random and lattice configurations match the oracle") {
  RandomPoints random(11);
  for (int round = 0; round < 200000; ++round) {
    const bool lattice = round % 2 == 1;
    Vec3 x[4];
    for (Vec3& v : x) v = lattice ? random.lattice() : random.point();
    const double oracle = static_cast<double>(triangle_distance2(x[0], x[1], x[2], x[3]));
    const PointTriangleType type = point_triangle_type(x[0], x[1], x[2], x[3]);
    REQUIRE(std::fabs(point_triangle_squared_distance(x[0], x[1], x[2], x[3]) - oracle) <=
            kTolerance * (1 + oracle));
    const auto w = point_triangle_weights(x[0], x[1], x[2], x[3], type);
    REQUIRE(std::fabs(w[0] + w[1] + w[2] - 1.0) < 1e-15);
    REQUIRE(std::min({w[0], w[1], w[2]}) >= -1e-16);
    REQUIRE(std::fabs(squared_norm(x[0] - x[1] * w[0] - x[2] * w[1] - x[3] * w[2]) - oracle) <=
            10 * kTolerance * (1 + oracle));
  }
}

TEST_CASE("edge-edge: random, lattice and nearly parallel configurations match the oracle") {
  RandomPoints random(12);
  for (int round = 0; round < 300000; ++round) {
    Vec3 x[4];
    for (Vec3& v : x) v = round % 3 == 1 ? random.lattice() : random.point();
    double tolerance = kTolerance;
    if (round % 3 == 2) {
      // Edge B parallel to A up to an angle of 1e-1 .. 1e-16.
      const double angle = std::pow(10.0, -random.integer(1, 16));
      const double s = random.uniform(-2.0, 2.0), length = random.uniform(0.2, 2.0);
      x[2] = x[0] + (x[1] - x[0]) * s + random.point() * 0.1;
      x[3] = x[2] + (x[1] - x[0]) * length + random.point() * angle;
      // Lines at an angle below 1e-10 count as parallel, which is an error of up to 1e-10 of their length.
      tolerance = 1e-9;
    }
    const double oracle = static_cast<double>(edge_edge_distance2(x[0], x[1], x[2], x[3]));
    CAPTURE(round);
    CAPTURE(squared_norm(cross(x[1] - x[0], x[3] - x[2])) / squared_norm(x[1] - x[0]) /
            squared_norm(x[3] - x[2]));
    const EdgeEdgeType type = edge_edge_type(x[0], x[1], x[2], x[3]);
    REQUIRE(std::fabs(edge_edge_squared_distance(x[0], x[1], x[2], x[3]) - oracle) <=
            tolerance * (1 + oracle));
    const auto w = edge_edge_weights(x[0], x[1], x[2], x[3], type);
    REQUIRE(std::fabs(weighted_distance2(w, x[0], x[1], x[2], x[3]) - oracle) <=
            10 * kTolerance * (1 + oracle));
    // Symmetric in the two edges.
    REQUIRE(std::fabs(edge_edge_squared_distance(x[2], x[3], x[0], x[1]) - oracle) <=
            tolerance * (1 + oracle));
  }
}

TEST_CASE("point-edge, point-point and degenerate primitives") {
  RandomPoints random(13);
  for (int round = 0; round < 50000; ++round) {
    Vec3 x[3];
    for (Vec3& v : x) v = round % 2 ? random.lattice() : random.point();
    const double oracle = static_cast<double>(segment_distance2(x[0], x[1], x[2]));
    REQUIRE(std::fabs(point_edge_squared_distance(x[0], x[1], x[2]) - oracle) <= kTolerance * (1 + oracle));
    const auto w = point_edge_weights(x[0], x[1], x[2], point_edge_type(x[0], x[1], x[2]));
    REQUIRE(std::fabs(squared_norm(x[0] - x[1] * w[0] - x[2] * w[1]) - oracle) <= kTolerance * (1 + oracle));
  }
  CHECK(point_edge_type({1, 0, 0}, {0, 0, 0}, {0, 0, 0}) == PointEdgeType::P_E0);
  const Vec3 p{0, 0, 1}, zero{};
  CHECK(point_triangle_squared_distance(p, zero, zero, zero) == 1.0);
  CHECK(edge_edge_squared_distance(p, p, zero, zero) == 1.0);
  CHECK(point_point_squared_distance(p, zero) == 1.0);
}

TEST_CASE("types name the feature") {
  const Vec3 a{0, 0, 0}, b{1, 0, 0}, c{0, 1, 0};
  using enum PointTriangleType;
  CHECK(point_triangle_type({-1, -1, 1}, a, b, c) == P_T0);
  CHECK(point_triangle_type({2, 0, 1}, a, b, c) == P_T1);
  CHECK(point_triangle_type({0, 3, 1}, a, b, c) == P_T2);
  CHECK(point_triangle_type({0.5, -1, 1}, a, b, c) == P_E0);
  CHECK(point_triangle_type({1, 1, 1}, a, b, c) == P_E1);
  CHECK(point_triangle_type({-1, 0.5, 1}, a, b, c) == P_E2);
  CHECK(point_triangle_type({0.2, 0.2, 1}, a, b, c) == P_T);
  using enum EdgeEdgeType;
  const Vec3 a0{-1, 0, 0}, a1{1, 0, 0};
  CHECK(edge_edge_type(a0, a1, {0, -1, 1}, {0, 1, 1}) == EA_EB);
  CHECK(edge_edge_type(a0, a1, {0, 1, 1}, {0, 2, 1}) == EA_EB0);
  CHECK(edge_edge_type(a0, a1, {0, 2, 1}, {0, 1, 1}) == EA_EB1);
  CHECK(edge_edge_type(a0, a1, {-2, -1, 1}, {-2, 1, 1}) == EA0_EB);
  CHECK(edge_edge_type(a0, a1, {2, -1, 1}, {2, 1, 1}) == EA1_EB);
  CHECK(edge_edge_type(a0, a1, {-2, 1, 1}, {-2, 2, 1}) == EA0_EB0);
  CHECK(edge_edge_type(a0, a1, {-2, 2, 1}, {-2, 1, 1}) == EA0_EB1);
  CHECK(edge_edge_type(a0, a1, {2, 1, 1}, {2, 2, 1}) == EA1_EB0);
  CHECK(edge_edge_type(a0, a1, {2, 2, 1}, {2, 1, 1}) == EA1_EB1);
  // Parallel: never a line-line type.
  CHECK(edge_edge_type(a0, a1, {-0.5, 1, 0}, {0.5, 1, 0}) != EA_EB);
}
