// Rods in scenes: what is refused and what the message says, clamps, frames at time 0.
#include <doctest/doctest.h>

#include <limits>

#include <stark/base/error.h>
#include <stark/base/rotation.h>
#include <stark/geometry/shapes.h>
#include <stark/sim/scene/scene.h>

using namespace stark;

namespace {

RodDescription straight(int segments = 4) {
  RodDescription rod;
  for (int i = 0; i <= segments; ++i) rod.mesh.vertices.push_back({0.25 * i, 0, 0});
  return rod;
}

/// The message that adding the rod raises.
std::string refusal(RodDescription rod) {
  Scene scene;
  rod.name = "cable";
  try {
    scene.add_rod(rod);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("rods have names of their own and count as bodies") {
  Scene scene;
  const BodyId a = scene.add_rod(straight()), b = scene.add_rod(straight());
  CHECK(scene.name(a) == "rod");
  CHECK(scene.name(b) == "rod_2");
  CHECK(scene.kind(b) == BodyKind::Rod);
  CHECK(scene.initial_positions(a).size() == 5);
  CHECK_THROWS_AS(scene.cloth(a), InvalidArgument);
}

TEST_CASE("polylines that are none are refused with the place and the remedy") {
  RodDescription rod;
  CHECK(contains(refusal(rod), "rod 'cable': the polyline has 0 points: must have at least 2"));
  rod.mesh.vertices = {{0, 0, 0}};
  CHECK(contains(refusal(rod), "1 points: must have at least 2"));
  rod = straight();
  rod.mesh.vertices[2].y = std::numeric_limits<double>::quiet_NaN();
  CHECK(contains(refusal(rod), "point 2"));
  rod = straight();
  rod.mesh.vertices[3] = rod.mesh.vertices[2];
  CHECK(contains(refusal(rod), "edge 2 has a length of 0 m: must not be degenerate"));
  rod = straight();
  rod.mesh.vertices[3] = {0.3, 0.001, 0};
  CHECK(contains(refusal(rod), "at point 2: must turn by less than 2.8 rad"));
  CHECK_THROWS_AS(Scene().add_rod(rod), InvalidMesh);
}

TEST_CASE("initial positions are checked like the rest shape") {
  RodDescription rod = straight();
  rod.initial_positions = {{0, 0, 0}};
  CHECK(contains(refusal(rod), "initial_positions"));
  rod.initial_positions.assign(5, Vec3{});
  CHECK(contains(refusal(rod), "initial_positions: edge 0 has a length of 0 m"));
}

TEST_CASE("a normal needs a part across the first edge") {
  RodDescription rod = straight();
  rod.normal = Vec3{2, 0, 0};
  CHECK(contains(refusal(rod), "along the first edge"));
  rod.normal = Vec3{};
  CHECK(contains(refusal(rod), "is zero or along"));
  rod.normal = Vec3{5, 0, 1};
  CHECK(refusal(rod).empty());
}

TEST_CASE("materials are checked: stiffness, section, damping") {
  RodDescription rod = straight();
  rod.material.radius = 0.0;
  CHECK(contains(refusal(rod), "radius"));
  rod.material.radius = 1e-3;
  rod.material.width = 1e-3;
  CHECK(contains(refusal(rod), "must both be > 0 for a rectangular section"));
  rod.material.height = 1e-3;
  CHECK(refusal(rod).empty());
  rod.material.youngs_modulus = -1.0;
  CHECK(contains(refusal(rod), "youngs_modulus"));
}

TEST_CASE("values for each segment are counted and ranged") {
  RodDescription rod = straight();
  rod.fields["bending_stiffness_1"] = {{1.0, 2.0}, true};
  CHECK(contains(refusal(rod), "bending_stiffness_1"));
  rod.fields["bending_stiffness_1"] = {{1.0, 2.0, 3.0, -4.0}, true};
  CHECK(contains(refusal(rod), "bending_stiffness_1"));
  rod.fields["bending_stiffness_1"] = {{1.0, 2.0, 3.0, 4.0}, true};
  CHECK(refusal(rod).empty());
  rod.fields["stiffness"] = {{1.0}, false};
  CHECK(contains(refusal(rod), "stiffness"));
}

TEST_CASE("clamping pins too, once, and is for rods alone") {
  Scene scene;
  const BodyId rod = scene.add_rod(straight());
  scene.pin(rod, std::vector<int32_t>{0, 2});
  scene.clamp(rod, std::vector<int32_t>{4, 0, 4});
  CHECK(scene.pins(rod).vertices == std::vector<int32_t>{0, 2, 4});
  CHECK(scene.pins(rod).clamped == std::vector<int32_t>{4, 0});
  CHECK_THROWS_AS(scene.clamp(rod, std::vector<int32_t>{5}), InvalidArgument);
  CHECK_THROWS_AS(scene.clamp(rod, std::vector<int32_t>{-1}), InvalidArgument);
  const BodyId box = scene.add_rigid({.mesh = make_box({1, 1, 1}), .mass = 1.0});
  CHECK_THROWS_AS(scene.clamp(box, std::vector<int32_t>{0}), InvalidArgument);
}

TEST_CASE("frames at time 0 follow the initial positions and the placement") {
  Scene scene;
  RodDescription rod = straight();
  rod.normal = Vec3{0, 0, 1};
  rod.rotation = exp_rotation({0, 0, 0.5});
  for (const Vec3& x : rod.mesh.vertices) rod.initial_positions.push_back({0, x.x, 0});
  const BodyId id = scene.add_rod(rod);
  for (const Mat3& frame : scene.initial_frames(id)) {
    CHECK(max_abs(frame.column(0) - Vec3{0, 0, 1}) < 1e-15);
    CHECK(max_abs(frame.column(2) - rod.rotation * Vec3{0, 1, 0}) < 1e-15);
  }
}
