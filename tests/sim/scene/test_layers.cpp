// Frames along paths of fibres: orientation, rings, bodies that start in another shape.
#include <doctest/doctest.h>

#include <cmath>

#include <stark/base/rotation.h>
#include <stark/geometry/shapes.h>
#include <stark/sim/scene/layers.h>

using namespace stark;

namespace {

double difference(const Mat3& a, const Mat3& b) {
  double largest = 0.0;
  for (int k = 0; k < 9; ++k) largest = std::max(largest, std::fabs(a.m[k] - b.m[k]));
  return largest;
}

}  // namespace

TEST_CASE("frames turn with the body and begin with the normal that was given") {
  Scene scene;
  const Mat3 R = exp_rotation({0.3, -0.5, 0.9});
  const BodyId sheet = scene.add_cloth({.mesh = make_grid(2, 2, 2, 2), .rotation = R});
  FibresDescription fibres{.body = sheet, .paths = {{0, 1, 2}}, .normal = Vec3{0, 0, 1}};
  const PathFrames frames = path_frames(scene, fibres)[0];
  CHECK(initial_frames(scene, fibres) == frames.initial);
  REQUIRE(frames.rest.size() == 3);
  CHECK(norm(frames.rest[0].column(0) - Vec3{0, 0, 1}) < 1e-15);
  CHECK(norm(frames.rest[0].column(2) - Vec3{1, 0, 0}) < 1e-15);
  for (int n = 0; n < 3; ++n) CHECK(difference(frames.initial[n], R * frames.rest[n]) < 1e-15);
  fibres.bending = false;
  CHECK(initial_frames(scene, fibres).empty());
}

TEST_CASE("frames of a body that starts in another shape follow it, without a strain from a rigid turn") {
  Scene scene;
  ClothDescription sheet{.mesh = make_grid(2, 2, 2, 2)};
  const Mat3 R = exp_rotation({0.0, 0.0, 0.7});
  for (const Vec3& v : sheet.mesh.vertices) sheet.initial_positions.push_back(R * v);
  const BodyId id = scene.add_cloth(sheet);
  const FibresDescription fibres{.body = id, .paths = {{0, 1, 4, 5}}};
  const PathFrames frames = path_frames(scene, fibres)[0];
  for (size_t n = 0; n < 4; ++n) CHECK(difference(frames.initial[n], R * frames.rest[n]) < 1e-14);
}

TEST_CASE("frames turn about the fibre with the body that starts twisted") {
  Scene scene;
  ClothDescription sheet{.mesh = make_grid(2, 2, 2, 2)};
  for (const Vec3& v : sheet.mesh.vertices)  // turned about x by an angle that grows with x
    sheet.initial_positions.push_back(exp_rotation({0.4 * v.x, 0, 0}) * v);
  const BodyId id = scene.add_cloth(sheet);
  const FibresDescription fibres{.body = id, .paths = {{3, 4, 5}}};  // the middle line
  const PathFrames frames = path_frames(scene, fibres)[0];
  for (size_t n = 0; n < 3; ++n) {
    const Mat3 R = exp_rotation({0.4 * (static_cast<double>(n) - 1.0), 0, 0});
    CHECK(difference(frames.initial[n], R * frames.rest[n]) < 1e-14);
    CHECK(std::abs(frames.neighbours[n] - (3 + static_cast<int32_t>(n))) == 3);  // straight across
  }
}

TEST_CASE("a ring has as many frames as vertices, with tangents between both neighbours at its start") {
  Scene scene;
  const BodyId sheet = scene.add_cloth({.mesh = make_grid(2, 2, 2, 2)});
  const FibresDescription fibres{.body = sheet, .paths = {{0, 1, 2, 5, 8, 7, 6, 3, 0}}};
  const PathFrames frames = path_frames(scene, fibres)[0];
  REQUIRE(frames.rest.size() == 8);
  const double half = std::sqrt(0.5);
  CHECK(norm(frames.rest[0].column(2) - Vec3{half, -half, 0}) < 1e-14);
  CHECK(norm(frames.rest[1].column(2) - Vec3{1, 0, 0}) < 1e-14);
  CHECK(norm(frames.rest[7].column(2) - Vec3{0, -1, 0}) < 1e-14);
}

TEST_CASE("a skin becomes a sheet with all vertices of its body") {
  Scene scene;
  const BodyId block = scene.add_solid({.mesh = make_tet_box({1, 1, 1}, {1, 1, 1})});
  const SkinId skin = scene.add_skin({.body = block, .rest_angles = RestAngles::Flat});
  const ClothDescription sheet = sheet_of(scene, scene.skin(skin));
  CHECK(sheet.mesh.vertices.size() == scene.solid(block).mesh.vertices.size());
  CHECK(sheet.mesh.triangles.size() == 12);
  CHECK(sheet.rest_angles == RestAngles::Flat);
}
