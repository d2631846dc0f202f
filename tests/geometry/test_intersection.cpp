// Exact predicates against integer arithmetic; segment-triangle tests against a rational oracle; point
// location.
#include <doctest/doctest.h>

#include <cstdint>

#include <stark/geometry/intersection.h>
#include <stark/geometry/shapes.h>

#include "support/random_points.h"

using namespace stark;
using test::RandomPoints;

namespace {

using Int = __int128;
struct IntPoint {
  Int x, y, z;
};

int sign(Int v) { return v > 0 ? 1 : (v < 0 ? -1 : 0); }

Int determinant(const IntPoint& a, const IntPoint& b, const IntPoint& c, const IntPoint& d) {
  const Int ux = b.x - a.x, uy = b.y - a.y, uz = b.z - a.z, vx = c.x - a.x, vy = c.y - a.y, vz = c.z - a.z;
  const Int wx = d.x - a.x, wy = d.y - a.y, wz = d.z - a.z;
  return (uy * vz - uz * vy) * wx + (uz * vx - ux * vz) * wy + (ux * vy - uy * vx) * wz;
}

}  // namespace

TEST_CASE("orient3d and orient2d agree with integer arithmetic on nearly degenerate input") {
  // Points a + i u + j v + small noise on a lattice of 2^-30: exact in double and, scaled, in 128-bit
  // integers.
  RandomPoints random(21);
  int zeros = 0;
  for (int round = 0; round < 200000; ++round) {
    int64_t x[4][3];
    int64_t u[3], v[3];
    for (int k = 0; k < 3; ++k) {
      x[0][k] = random.integer(-(1 << 28), 1 << 28);
      u[k] = random.integer(-(1 << 24), 1 << 24);
      v[k] = random.integer(-(1 << 24), 1 << 24);
    }
    for (int p = 1; p < 4; ++p) {
      const int i = random.integer(-16, 16), j = random.integer(-16, 16);
      for (int k = 0; k < 3; ++k)
        x[p][k] = x[0][k] + i * u[k] + j * v[k] + (round % 2 ? random.integer(-1, 1) : 0);
    }
    Vec3 points[4];
    IntPoint exact[4];
    for (int p = 0; p < 4; ++p) {
      points[p] = {x[p][0] * 0x1p-30, x[p][1] * 0x1p-30, x[p][2] * 0x1p-30};
      exact[p] = {x[p][0], x[p][1], x[p][2]};
    }
    const int expected = sign(determinant(exact[0], exact[1], exact[2], exact[3]));
    zeros += expected == 0;
    REQUIRE(orient3d(points[0], points[1], points[2], points[3]) == expected);
    REQUIRE(orient3d(points[1], points[0], points[2], points[3]) == -expected);
    const Int flat = (exact[1].x - exact[0].x) * (exact[2].y - exact[0].y) -
                     (exact[1].y - exact[0].y) * (exact[2].x - exact[0].x);
    REQUIRE(orient2d(points[0].x, points[0].y, points[1].x, points[1].y, points[2].x, points[2].y) ==
            sign(flat));
  }
  CHECK(zeros > 90000);  // every other round is exactly coplanar
}

TEST_CASE("orient3d sees the last bit where plain arithmetic cannot") {
  const Vec3 a{12.0, 12.0, 0.0}, b{24.0, 24.0, 0.0}, c{0.5, 0.5, 1.0};
  const double up = std::nextafter(0.5, 1.0);
  CHECK(orient3d(a, b, c, {0.5, 0.5, 7.0}) == 0);
  CHECK(orient3d(a, b, c, {up, 0.5, 7.0}) == -orient3d(a, b, c, {0.5, up, 7.0}));
  CHECK(orient3d(a, b, c, {up, 0.5, 7.0}) != 0);
}

TEST_CASE("segment-triangle: touching counts, near misses do not") {
  const Vec3 a{0, 0, 0}, b{1, 0, 0}, c{0, 1, 0};
  CHECK(segment_intersects_triangle({0.2, 0.2, -1}, {0.2, 0.2, 1}, a, b, c));
  CHECK(segment_intersects_triangle({0.2, 0.2, 0}, {0.2, 0.2, 1}, a, b, c));
  CHECK_FALSE(segment_intersects_triangle({0.2, 0.2, 5e-324}, {0.2, 0.2, 1}, a, b, c) == true);
  CHECK(segment_intersects_triangle({0.5, 0.5, -1}, {0.5, 0.5, 1}, a, b, c));
  CHECK_FALSE(segment_intersects_triangle({0.5, std::nextafter(0.5, 1), -1}, {0.5, std::nextafter(0.5, 1), 1},
                                          a, b, c));
  CHECK(segment_intersects_triangle({0, 0, -1}, {0, 0, 1}, a, b, c));
  CHECK_FALSE(segment_intersects_triangle({-1e-300, 0.5, -1}, {-1e-300, 0.5, 1}, a, b, c));
  // Coplanar.
  CHECK(segment_intersects_triangle({-1, 0.2, 0}, {2, 0.2, 0}, a, b, c));
  CHECK(segment_intersects_triangle({0.1, 0.1, 0}, {0.2, 0.2, 0}, a, b, c));
  CHECK(segment_intersects_triangle({1, 0, 0}, {2, 0, 0}, a, b, c));
  CHECK_FALSE(segment_intersects_triangle({1.5, 0, 0}, {2, 0, 0}, a, b, c));
  CHECK_FALSE(segment_intersects_triangle({1, 1, 0}, {0.6, 0.5, 0}, a, b, c));
}

TEST_CASE("segment-triangle equals the clipped-line oracle on lattice configurations") {
  // Oracle in integers: intersection of the line with the plane at rational parameter, inside test by integer
  // areas.
  RandomPoints random(22);
  int hits = 0;
  for (int round = 0; round < 200000; ++round) {
    Vec3 x[5];
    IntPoint e[5];
    for (int k = 0; k < 5; ++k) {
      x[k] = random.lattice(3);
      e[k] = {static_cast<Int>(x[k].x), static_cast<Int>(x[k].y), static_cast<Int>(x[k].z)};
    }
    const Int sp = determinant(e[2], e[3], e[4], e[0]), sq = determinant(e[2], e[3], e[4], e[1]);
    if (sp == 0 && sq == 0) continue;
    bool expected = false;
    if (sign(sp) * sign(sq) <= 0) {
      // Point (sp q - sq p) / (sp - sq), compared in scaled integers with the triangle's three edge planes.
      const Int w = sp - sq;
      const IntPoint m{sp * e[1].x - sq * e[0].x, sp * e[1].y - sq * e[0].y, sp * e[1].z - sq * e[0].z};
      const auto scaled = [&](const IntPoint& p) { return IntPoint{p.x * w, p.y * w, p.z * w}; };
      const IntPoint a = scaled(e[2]), b = scaled(e[3]), c = scaled(e[4]);
      const auto area = [](const IntPoint& p, const IntPoint& q, const IntPoint& r) {
        const Int ux = q.x - p.x, uy = q.y - p.y, uz = q.z - p.z, vx = r.x - p.x, vy = r.y - p.y,
                  vz = r.z - p.z;
        return IntPoint{uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx};
      };
      const IntPoint n = area(a, b, c), n0 = area(a, b, m), n1 = area(b, c, m), n2 = area(c, a, m);
      const auto along = [&](const IntPoint& k) { return sign(k.x * n.x + k.y * n.y + k.z * n.z); };
      expected = along(n0) >= 0 && along(n1) >= 0 && along(n2) >= 0;
    }
    hits += expected;
    REQUIRE(segment_intersects_triangle(x[0], x[1], x[2], x[3], x[4]) == expected);
    REQUIRE(segment_intersects_triangle(x[1], x[0], x[4], x[3], x[2]) == expected);
  }
  CHECK(hits > 10000);
}

TEST_CASE("a long edge meets a triangle where it crosses it, in its plane in the middle of what they share") {
  const Vec3 a{0, 0, 0}, b{1, 0, 0}, c{0, 1, 0};
  CHECK(norm(meeting_point({0.2, 0.3, -1}, {0.2, 0.3, 99}, a, b, c) - Vec3{0.2, 0.3, 0}) < 1e-14);
  CHECK(norm(meeting_point({-1, 0.5, 0}, {20, 0.5, 0}, a, b, c) - Vec3{0.25, 0.5, 0}) < 1e-14);
  CHECK(norm(meeting_point({0.1, 0.1, 0}, {0.1, 0.1, 5}, a, b, c) - Vec3{0.1, 0.1, 0}) < 1e-14);
  CHECK(norm(meeting_point({1, 0, 0}, {9, 0, 0}, a, b, c) - Vec3{1, 0, 0}) < 1e-14);  // at a corner
}

TEST_CASE("point location in a torus agrees with the analytic one away from the facets") {
  const TriangleMesh torus = make_torus(1.0, 0.4, 64, 64);
  RandomPoints random(23);
  int inside = 0;
  for (int round = 0; round < 3000; ++round) {
    const Vec3 p{random.uniform(-1.5, 1.5), random.uniform(-1.5, 1.5), random.uniform(-0.5, 0.5)};
    const double r = std::hypot(std::hypot(p.x, p.y) - 1.0, p.z);
    if (std::fabs(r - 0.4) < 0.01) continue;
    inside += r < 0.4;
    REQUIRE(locate_point(p, torus.vertices, torus.triangles) ==
            (r < 0.4 ? PointLocation::Inside : PointLocation::Outside));
  }
  CHECK(inside > 300);
}

TEST_CASE("point location on symmetric points of a box") {
  const TriangleMesh box = make_box({2, 2, 2}, 2);
  CHECK(locate_point({0, 0, 0}, box.vertices, box.triangles) == PointLocation::Inside);
  CHECK(locate_point({0.5, 0.5, 0.5}, box.vertices, box.triangles) == PointLocation::Inside);
  CHECK(locate_point({1, 0, 0}, box.vertices, box.triangles) == PointLocation::OnSurface);
  CHECK(locate_point({1, 1, 1}, box.vertices, box.triangles) == PointLocation::OnSurface);
  CHECK(locate_point({std::nextafter(1.0, 0.0), 0.3, 0.2}, box.vertices, box.triangles) ==
        PointLocation::Inside);
  CHECK(locate_point({std::nextafter(1.0, 2.0), 0.3, 0.2}, box.vertices, box.triangles) ==
        PointLocation::Outside);
  CHECK(locate_point({0, 0, 5}, box.vertices, box.triangles) == PointLocation::Outside);
}
