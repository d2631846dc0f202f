// The z-buffers against casting a ray through every sample. [Moeller, Trumbore 1997]
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include <doctest/doctest.h>

#include <stark/io/detail/raster_scene.h>

namespace {

using stark::Vec3;
using stark::raster::Triangle;

/// Distance along the ray in units of its direction, and how far inside the triangle the hit is (0 on its
/// border).
struct Hit {
  double distance, margin;
};

std::optional<Hit> intersect(const Triangle& triangle, const Vec3& origin, const Vec3& ray) {
  const Vec3 u = triangle.corners[1] - triangle.corners[0], v = triangle.corners[2] - triangle.corners[0];
  const Vec3 p = cross(ray, v);
  const double determinant = dot(u, p);
  if (std::fabs(determinant) < 1e-15) return std::nullopt;
  const Vec3 s = origin - triangle.corners[0];
  const double b = dot(s, p) / determinant;
  const Vec3 q = cross(s, u);
  const double c = dot(ray, q) / determinant;
  return Hit{dot(v, q) / determinant, std::fmin(std::fmin(b, c), 1.0 - b - c)};
}

/// Uniform in [-1, 1], the same on every machine.
struct Random {
  uint64_t state = 12345;
  double operator()() {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<double>(state >> 11) / 4503599627370496.0 - 1.0;
  }
  Vec3 point() { return {(*this)(), (*this)(), (*this)()}; }
};

stark::raster::TriangleScene random_triangles(int count) {
  Random random;
  stark::raster::TriangleScene scene;
  for (int i = 0; i < count; ++i) {
    const Vec3 center = 1.5 * random.point();
    Triangle t{{center + random.point(), center + random.point(), center + random.point()}, {}, 0};
    t.normal = normalized(cross(t.corners[1] - t.corners[0], t.corners[2] - t.corners[0]));
    scene.triangles.push_back(t);
  }
  return scene;
}

}  // namespace

TEST_CASE("every sample shows the triangle that its ray meets first") {
  const auto scene = random_triangles(40);
  stark::RasterCamera camera;
  camera.eye = {0.4, -1.2, 0.3};  // among the triangles: many cross the near plane or lie behind
  camera.target = {0.0, 1.0, 0.0};
  camera.vertical_fov = 1.2;
  const int width = 90, height = 60;
  const double near_distance = 0.01;
  const stark::raster::CameraFrame frame(camera, static_cast<double>(width) / height);
  stark::ThreadPool pool(2);
  const auto buffer = stark::raster::draw_visibility(scene, frame, width, height, near_distance, pool);
  int compared = 0, empty = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const Vec3 ray = frame.ray((x + 0.5) / width, (y + 0.5) / height);
      int first = -1;
      double distance = std::numeric_limits<double>::infinity(), second = distance, margin = 1.0;
      for (size_t t = 0; t < scene.triangles.size(); ++t) {
        const auto hit = intersect(scene.triangles[t], frame.eye, ray);
        if (!hit || hit->distance < near_distance) continue;
        margin = std::fmin(margin, std::fabs(hit->margin));
        if (hit->margin < 0.0) continue;
        if (hit->distance < distance) {
          second = distance;
          distance = hit->distance;
          first = static_cast<int>(t);
        } else {
          second = std::fmin(second, hit->distance);
        }
      }
      // Samples on an edge, or with two surfaces closer than float can tell apart, may go either way.
      if (margin < 1e-6 || second - distance < 1e-4) continue;
      ++compared;
      empty += first < 0;
      const size_t i = static_cast<size_t>(y) * width + x;
      CHECK(buffer.triangle[i] == first);
      if (first >= 0) CHECK(buffer.inverse_depth[i] == doctest::Approx(1.0 / distance).epsilon(1e-5));
    }
  CHECK(compared > 5000);
  CHECK(empty > 100);
  CHECK(empty < 5000);
}

TEST_CASE("a shadow map tells lit from shaded points away from borders") {
  const auto scene = random_triangles(6);
  const Vec3 light = stark::normalized(Vec3{0.3, -0.5, 0.8});
  stark::raster::ShadowMap map(light, {0, 0, 0}, 4.0, 512);
  map.draw(scene.triangles);
  Random random;
  random.state = 999;
  constexpr double kClear = 3.0 * 8.0 / 512.0;  // three texels [m]
  int lit = 0, shaded = 0;
  for (int k = 0; k < 8000; ++k) {
    const Vec3 point = 2.5 * random.point();
    // A blocker counts when it is clearly in front and the ray passes well inside or well outside of it.
    bool blocked = false, unclear = false;
    for (const Triangle& t : scene.triangles) {
      const auto hit = intersect(t, point, light);
      if (!hit || hit->distance < -0.1) continue;
      // Least height of the triangle as the light sees it [m]: turns the margin into a distance from the
      // border.
      const auto& c = t.corners;
      const double longest = std::fmax(norm(c[1] - c[0]), std::fmax(norm(c[2] - c[1]), norm(c[0] - c[2])));
      const double height = std::fabs(dot(cross(c[1] - c[0], c[2] - c[0]), light)) / longest;
      if (std::fabs(hit->margin) * height < kClear || std::fabs(hit->distance) < 0.1) unclear = true;
      blocked = blocked || (hit->margin > 0.0 && hit->distance > 0.0);
    }
    if (unclear) continue;
    (blocked ? shaded : lit) += 1;
    CHECK(map.visibility(point, light) == (blocked ? 0.0 : 1.0));
  }
  CHECK(lit > 200);
  CHECK(shaded > 200);
}

TEST_CASE("outside of its square a shadow map lights everything") {
  stark::raster::ShadowMap map({0, 0, 1}, {0, 0, 0}, 1.0, 64);
  const Triangle roof{{Vec3{-9, -9, 1}, Vec3{9, -9, 1}, Vec3{0, 9, 1}}, {0, 0, 1}, 0};
  map.draw(std::vector{roof});
  CHECK(map.visibility({0, 0, 0}, {0, 0, 1}) == 0.0);
  CHECK(map.visibility({2, 0, 0}, {0, 0, 1}) == 1.0);
}

TEST_CASE("a light of some size casts a penumbra that grows with the distance") {
  constexpr double kSpread = 0.1;
  for (const double height : {0.2, 0.4, 0.8}) {
    // Half of the plane is covered, and the light is seen past the edge as a disk behind a straight screen.
    stark::raster::ShadowMap map({0, 0, 1}, {0, 0, 0}, 1.0, 256, kSpread);
    const Triangle roof{{Vec3{0, -9, height}, Vec3{0, 9, height}, Vec3{-9, 0, height}}, {0, 0, 1}, 0};
    map.draw(std::vector{roof});
    double before = 0.0, error = 0.0;
    for (double t = -1.5; t < 1.5; t += 0.05) {
      const double x = t * kSpread * height, c = std::clamp(t, -1.0, 1.0);
      const double seen = 1.0 - (std::acos(c) - c * std::sqrt(1.0 - c * c)) / std::numbers::pi;
      const double share = map.visibility({x, 0.013, 0.0}, {0, 0, 1});
      CHECK(share >= before);
      error = std::max(error, std::fabs(share - seen));
      before = share;
    }
    CHECK(error < 0.2);  // of eight samples and texels of 8 mm
    CHECK(map.visibility({-0.5, 0, 0}, {0, 0, 1}) == 0.0);
    CHECK(map.visibility({0.5, 0, 0}, {0, 0, 1}) == 1.0);
  }
}

TEST_CASE("a surface under a slanting light of some size does not shade itself") {
  for (const double slant : {0.2, 0.5, 0.8}) {
    const Vec3 light = stark::normalized(Vec3{std::sin(slant), 0.3, std::cos(slant)});
    stark::raster::ShadowMap map(light, {0, 0, 0}, 2.0, 256, 0.3);
    const Triangle floor{{Vec3{-9, -9, 0}, Vec3{9, -9, 0}, Vec3{0, 9, 0}}, {0, 0, 1}, 0};
    const Triangle roof{{Vec3{-0.2, -0.1, 0.9}, Vec3{0.2, -0.1, 0.9}, Vec3{0, 0.2, 0.9}}, {0, 0, 1}, 0};
    map.draw(std::vector{floor, roof});
    int shaded = 0;
    for (double x = -1.0; x <= 1.0; x += 0.037)
      for (double y = -1.0; y <= 1.0; y += 0.041) {
        const Vec3 foot{x + light.x / light.z * 0.9, y + light.y / light.z * 0.9, 0.9};
        const bool is_clear = norm(foot - Vec3{0, 0, 0.9}) > 0.3 + 0.3 * 0.9 / light.z / light.z;
        if (is_clear) CHECK(map.visibility({x, y, 0}, {0, 0, 1}) == 1.0);
        shaded += map.visibility({x, y, 0}, {0, 0, 1}) < 0.99 ? 1 : 0;
      }
    CHECK(shaded > 0);
  }
}
