// Corner normals of the rasteriser: across sharp edges each face keeps its own, across smooth ones they
// agree.
#include <cmath>
#include <numbers>
#include <vector>

#include <doctest/doctest.h>

#include <stark/io/detail/raster_scene.h>

namespace {

using stark::Vec3;
using Triangles = std::vector<std::array<int32_t, 3>>;

/// A roof of two squares that meet along the y axis under the angle `fold` between their normals [rad].
stark::raster::TriangleScene roof(double fold, double crease_angle) {
  const double a = 0.5 * fold;
  const std::vector<Vec3> points{{0, 0, 0},
                                 {0, 1, 0},
                                 {std::cos(a), 0, -std::sin(a)},
                                 {std::cos(a), 1, -std::sin(a)},
                                 {-std::cos(a), 0, -std::sin(a)},
                                 {-std::cos(a), 1, -std::sin(a)}};
  const Triangles triangles{{0, 2, 3}, {0, 3, 1}, {0, 1, 5}, {0, 5, 4}};
  stark::RasterMesh mesh;
  mesh.positions = points;
  mesh.triangles = triangles;
  mesh.crease_angle = crease_angle;
  return stark::raster::flatten(std::vector{mesh});
}

}  // namespace

TEST_CASE("an edge sharper than the crease angle keeps the normals of its faces") {
  const auto scene = roof(1.0, 0.9);
  REQUIRE(scene.triangles.size() == 4);
  for (size_t t = 0; t < 4; ++t)
    for (int e = 0; e < 3; ++e) CHECK(norm(scene.corner_normals[t][e] - scene.triangles[t].normal) < 1e-14);
}

TEST_CASE("an edge blunter than the crease angle gets one normal on the ridge") {
  const auto scene = roof(1.0, 1.1);
  // Both squares have the same area, so by symmetry the ridge looks straight up; vertex 0 lies in all four
  // triangles with equal weights, vertex 1 in one of the right and one of the left.
  CHECK(norm(scene.corner_normals[0][0] - Vec3{0, 0, 1}) < 1e-14);
  CHECK(norm(scene.corner_normals[1][2] - Vec3{0, 0, 1}) < 1e-14);
  CHECK(norm(scene.corner_normals[2][1] - Vec3{0, 0, 1}) < 1e-14);
  CHECK(norm(scene.corner_normals[0][1] - scene.triangles[0].normal) < 1e-14);
}

TEST_CASE("pi smooths even a folded sheet, and meshes never share normals") {
  const auto scene = roof(3.0, std::numbers::pi);
  CHECK(norm(scene.corner_normals[0][0] - Vec3{0, 0, 1}) < 1e-12);
  const std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const Triangles up{{0, 1, 2}}, down{{0, 2, 1}};
  stark::RasterMesh a, b;
  a.positions = b.positions = points;
  a.triangles = up;
  b.triangles = down;
  const auto two = stark::raster::flatten(std::vector{a, b});
  CHECK(two.corner_normals[0][0] == Vec3{0, 0, 1});
  CHECK(two.corner_normals[1][0] == Vec3{0, 0, -1});
  CHECK(two.triangles[1].mesh == 1);
}
