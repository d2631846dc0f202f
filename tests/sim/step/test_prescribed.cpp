// Bodies that are scripted or fixed on both sides and meet: reported, whichever way they do.
#include <doctest/doctest.h>

#include <algorithm>
#include <numbers>

#include <stark/geometry/shapes.h>
#include <stark/sim/simulation.h>

using namespace stark;

namespace {

RigidDescription box(const std::string& name, const Vec3& size, const Vec3& position,
                     Motion motion = Motion::Scripted) {
  return {.name = name, .mesh = make_box(size), .motion = motion, .position = position};
}

bool says_meeting(const StepReport& report) {
  return std::ranges::find(report.caveats, Caveat::PrescribedOverlap) != report.caveats.end();
}

/// A scripted box of 10 cm beside a fixed wall of 2 mm, 1 cm apart.
Scene wall_scene() {
  Scene scene;
  scene.add_rigid(box("wall", {0.002, 0.4, 0.4}, {0.061, 0, 0}, Motion::Fixed));
  scene.add_rigid(box("ram", {0.1, 0.1, 0.1}, {0, 0, 0}));
  return scene;
}

}  // namespace

TEST_CASE("a scripted body that goes into a fixed one is named as long as it is there") {
  Simulation sim(wall_scene());
  const BodyId ram = sim.scene().find("ram");
  CHECK_FALSE(says_meeting(sim.step()));
  sim.set_pose(ram, {0.02, 0, 0}, Mat3::identity());
  CHECK(says_meeting(sim.step()));
  CHECK(sim.report().message.find("'wall' and 'ram'") != std::string::npos);
  CHECK(says_meeting(sim.step()));  // at rest there
  sim.set_pose(ram, {0, 0, 0}, Mat3::identity());
  CHECK_FALSE(says_meeting(sim.step()));
}

TEST_CASE("a scripted body that passes through another in one step is named") {
  Simulation sim(wall_scene());
  sim.set_pose(sim.scene().find("ram"), {0.3, 0, 0}, Mat3::identity());
  CHECK(says_meeting(sim.step()));
  CHECK_FALSE(says_meeting(sim.step()));
}

TEST_CASE("a scripted body inside a fixed one is named, unless that is hollow") {
  for (const bool hollow : {false, true}) {
    Scene scene;
    RigidDescription block = box("block", {0.4, 0.4, 0.4}, {}, Motion::Fixed);
    block.hollow = hollow;
    scene.add_rigid(block);
    scene.add_rigid(box("core", {0.1, 0.1, 0.1}, {}));
    Simulation sim(scene);
    CHECK(says_meeting(sim.step()) != hollow);
  }
}

TEST_CASE("scripted bodies that touch, slide along each other or turn in a ring do not meet") {
  Scene scene;
  SUBCASE("slide flush over an edge") {
    scene.add_rigid({.mesh = make_grid(0.3, 0.3, 1, 1), .motion = Motion::Fixed});
    scene.add_rigid(box("slider", {0.1, 0.1, 0.1}, {0.08, 0.013, 0.05}));
    scene.add_rigid(box("neighbour", {0.1, 0.1, 0.1}, {0.08, 0.113, 0.05}));
    Simulation sim(scene);
    sim.set_velocity(BodyId{1}, {1, 0, 0}, {});
    for (int n = 0; n < 10; ++n) CHECK_FALSE(says_meeting(sim.step()));
  }
  SUBCASE("close up") {
    scene = wall_scene();
    Simulation sim(scene);
    sim.set_pose(scene.find("ram"), {0.01, 0, 0}, Mat3::identity());
    for (int n = 0; n < 3; ++n) CHECK_FALSE(says_meeting(sim.step()));
  }
  SUBCASE("a paddle in a drum") {
    TriangleMesh drum = make_cylinder(0.1, 0.2, 64, 1);
    RigidDescription shell{.mesh = drum, .motion = Motion::Fixed, .hollow = true};
    scene.add_rigid(shell);
    RigidDescription paddle = box("paddle", {0.18, 0.02, 0.1}, {});
    paddle.angular_velocity = {0, 0, 0.124 * std::numbers::pi * 60.0};  // 22 degrees a step
    scene.add_rigid(paddle);
    Simulation sim(scene);
    for (int n = 0; n < 10; ++n) CHECK_FALSE(says_meeting(sim.step()));
  }
}

TEST_CASE("fixed bodies and pairs without contact are left alone") {
  Scene scene = wall_scene();
  scene.add_rigid(box("pillar", {0.1, 0.1, 0.1}, {0.061, 0, 0.2}, Motion::Fixed));
  const BodyId wall = scene.find("wall"), ram = scene.find("ram");
  scene.disable_contact(wall, ram);
  Simulation sim(scene);
  sim.set_pose(ram, {0.02, 0, 0}, Mat3::identity());
  CHECK_FALSE(says_meeting(sim.step()));
}
