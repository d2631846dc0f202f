// Attachments in a simulation: forces, breaking, next to joints and actuators, rewinding, refusals.
#include <doctest/doctest.h>

#include <stark/stark.h>

using namespace stark;
using doctest::Approx;

namespace {

Settings no_contact() {
  Settings settings;
  settings.time.step = 0.01;
  settings.contact.enabled = false;
  return settings;
}

RigidDescription cube(const Vec3& position) {
  return {.mesh = make_box({0.1, 0.1, 0.1}), .mass = 1.0, .position = position};
}

AttachmentDescription nail(BodyId body, const Vec3& place, double break_force) {
  return {.a = body_points(body, {{0, 0, 0}}), .b = {world_points({place})}, .break_force = break_force};
}

/// A box on a motor, one on a nail that breaks, one on a nail that does not.
struct Mixed {
  Scene scene;
  BodyId turning = scene.add_rigid(cube({0, 0, 0})), weak = scene.add_rigid(cube({1, 0, 0})),
         strong = scene.add_rigid(cube({2, 0, 0}));
  JointId hinge = scene.add_joint(
      {.definition = find_joint("hinge"), .a = world_frame({0, 0, 0}), .b = body_frame(turning, {0, 0, 0})});
  ActuatorId motor = scene.add_actuator(
      {.definition = find_actuator("effort"), .on = {{hinge, "angle"}}, .values = {{"target", 0.01}}});
  AttachmentId breaks = scene.add_attachment(nail(weak, {1, 0, 0}, 5.0));
  AttachmentId holds = scene.add_attachment(nail(strong, {2, 0, 0}, 15.0));
};

}  // namespace

TEST_CASE("pairs hold up to their force, next to joints and actuators, and rewinding brings the same bits") {
  Mixed mixed;
  Simulation sim(mixed.scene, no_contact());
  REQUIRE_FALSE(sim.step().failed());
  CHECK(sim.attachment_status(mixed.breaks) == std::vector<int32_t>{-1});
  CHECK(sim.attachment_status(mixed.holds) == std::vector<int32_t>{1});
  CHECK(sim.attachment_forces(mixed.holds)[0].z == Approx(9.81).epsilon(1e-4));
  CHECK(sim.attachment_forces(mixed.breaks)[0].z == Approx(9.81).epsilon(1e-4));  // the step that broke it
  CHECK(sim.joint_rates(mixed.hinge)[0] > 0.0);
  CHECK(sim.actuator_effort(mixed.motor) == Approx(0.01));
  const State middle = sim.state();
  for (int i = 0; i < 3; ++i) REQUIRE_FALSE(sim.step().failed());
  CHECK(norm(sim.attachment_forces(mixed.breaks)[0]) == 0.0);
  CHECK(sim.position(mixed.weak).z < -5e-3);
  CHECK(sim.position(mixed.strong).z == Approx(0.0).epsilon(1e-6));
  const State end = sim.state();
  sim.set_state(middle);
  for (int i = 0; i < 3; ++i) REQUIRE_FALSE(sim.step().failed());
  CHECK(first_difference(sim.state(), end).empty());
}

TEST_CASE("released pairs are held again, broken ones are not") {
  Mixed mixed;
  Simulation sim(mixed.scene, no_contact());
  sim.step();
  for (const AttachmentId id : {mixed.breaks, mixed.holds}) sim.set_attachment_enabled(id, false);
  CHECK(sim.attachment_status(mixed.holds) == std::vector<int32_t>{0});
  for (const AttachmentId id : {mixed.breaks, mixed.holds}) sim.set_attachment_enabled(id, true);
  CHECK(sim.attachment_status(mixed.breaks) == std::vector<int32_t>{-1});
  CHECK(sim.attachment_status(mixed.holds) == std::vector<int32_t>{1});
  State other = sim.state();
  other.attachment_held.pop_back();
  CHECK_THROWS_WITH_AS(sim.set_state(other), doctest::Contains("attached points"), InvalidArgument);
}

TEST_CASE("released pairs that are away from their places are counted, and the farthest is named") {
  Scene scene;
  const BodyId box = scene.add_rigid(cube({0, 0, 0}));
  AttachmentDescription two{.a = body_points(box, {{0, 0, 0}, {0, 0, 0.01}}),
                            .b = {world_points({{0, 0, 0}, {0, 0, 0.03}})},
                            .enabled = false};
  const AttachmentId id = scene.add_attachment(two);
  Simulation sim(scene, no_contact());
  CHECK_THROWS_WITH_AS(
      sim.check_attachment_agrees(id),
      doctest::Contains("'attachment': 1 of 2 released pairs are away from where they were attached "
                        "at time 0, pair 1 by 0.02 m: must be within 1e-06 m"),
      InvalidArgument);
  sim.set_attachment_enabled(id, true);
  CHECK_NOTHROW(sim.check_attachment_agrees(id));  // what is held is not asked
}

TEST_CASE("points that are apart at time 0 are refused, unless they are released") {
  Scene scene;
  const BodyId box = scene.add_rigid(cube({0, 0, 0}));
  AttachmentDescription off = nail(box, {0, 0, 0.01}, 1.0);
  off.enabled = false;
  scene.add_attachment(off);
  CHECK_NOTHROW(Simulation(scene, no_contact()));
  off.enabled = true;
  scene.add_attachment(off);
  CHECK_THROWS_WITH_AS(Simulation(scene, no_contact()),
                       doctest::Contains("attachment 'attachment_2': the points of pair 0 are 0.01 m apart"),
                       InvalidArgument);
}
