// States that are refused, going on where another simulation was with what its sensors read, targets.
#include <doctest/doctest.h>

#include <cmath>

#include <stark/base/error.h>
#include <stark/base/rotation.h>
#include <stark/geometry/shapes.h>
#include <stark/sim/simulation.h>

using namespace stark;

namespace {

/// A box falls on a floor, a cloth on the box.
Scene falling_scene() {
  Scene scene;
  scene.add_rigid({.name = "floor", .mesh = make_box({1, 1, 0.1}), .motion = Motion::Fixed});
  scene.add_rigid({.name = "box",
                   .mesh = make_box({0.1, 0.1, 0.1}),
                   .mass = 0.1,
                   .position = {0, 0, 0.102},
                   .velocity = {0.1, 0, -0.2}});
  scene.add_cloth({.name = "cloth",
                   .mesh = make_grid(0.2, 0.2, 4, 4),
                   .material = materials::cotton(),
                   .position = {0, 0, 0.155}});
  return scene;
}

void advance(Simulation& sim, int steps) {
  for (int n = 0; n < steps; ++n) REQUIRE_FALSE(sim.step().failed());
}

void check_same_contacts(const Simulation& a, const Simulation& b) {
  const auto of_a = a.contacts(), of_b = b.contacts();
  REQUIRE(of_a.size() == of_b.size());
  for (size_t k = 0; k < of_a.size(); ++k) {
    CHECK(of_a[k].normal_force.z == of_b[k].normal_force.z);
    CHECK(of_a[k].friction.x == of_b[k].friction.x);
    CHECK(of_a[k].slip.x == of_b[k].slip.x);
  }
}

}  // namespace

TEST_CASE("a simulation that resumes reads the same sensors and goes on with the same bits") {
  const Scene scene = falling_scene();
  Simulation sim(scene);
  advance(sim, 4);
  const State before = sim.state();
  advance(sim, 1);
  Simulation resumed(scene);
  REQUIRE(resumed.resume(before, 1e300, sim.state()));
  CHECK(resumed.state() == sim.state());
  CHECK_FALSE(sim.contacts().empty());
  check_same_contacts(resumed, sim);
  CHECK(resumed.acceleration(scene.find("box"), {}).z == sim.acceleration(scene.find("box"), {}).z);
  CHECK(resumed.report().step == sim.report().step);
  CHECK(resumed.report().energy.friction == sim.report().energy.friction);
  for (int n = 0; n < 4; ++n) {
    advance(sim, 1);
    advance(resumed, 1);
    CHECK(first_difference(resumed.state(), sim.state()) == "");
  }
}

TEST_CASE("a step that was cut short is taken again with its length") {
  const Scene scene = falling_scene();
  Simulation sim(scene), resumed(scene);
  advance(sim, 2);
  const State before = sim.state();
  REQUIRE_FALSE(sim.step(0.004).failed());
  CHECK_FALSE(resumed.resume(before, 1e300, sim.state()));
  REQUIRE(resumed.resume(before, 0.004, sim.state()));
  CHECK(resumed.report().time_step == 0.004);
}

TEST_CASE("what was set after the last step is kept") {
  Scene scene;
  const BodyId plate = scene.add_rigid({.mesh = make_box({1, 1, 0.1}), .motion = Motion::Scripted});
  Simulation sim(scene), resumed(scene);
  advance(sim, 1);
  const State before = sim.state();
  advance(sim, 1);
  sim.set_pose(plate, {0, 0, 0.1}, Mat3::identity());
  REQUIRE(resumed.resume(before, 1e300, sim.state()));
  CHECK(resumed.state() == sim.state());
  advance(resumed, 1);
  CHECK(resumed.position(plate).z == 0.1);
}

TEST_CASE("a step that comes out differently leaves the state as set_state does") {
  const Scene scene = falling_scene();
  Simulation sim(scene), resumed(scene);
  advance(sim, 4);
  State before = sim.state();
  advance(sim, 1);
  before.body_velocity[1].x += 1e-9;
  CHECK_FALSE(resumed.resume(before, 1e300, sim.state()));
  CHECK(resumed.state() == sim.state());
  CHECK(resumed.contacts().empty());
}

TEST_CASE("states with arrays of other lengths or numbers that no state can have are refused") {
  Simulation sim(falling_scene());
  const State good = sim.state();
  State bad = good;
  SUBCASE("every array") {
    bad.body_angular_velocity.pop_back();
    CHECK_THROWS_WITH_AS(sim.set_state(bad), doctest::Contains("'body_angular_velocity' is not as long"),
                         InvalidArgument);
  }
  SUBCASE("not finite") {
    bad.point_velocity[7].y = NAN;
    CHECK_THROWS_WITH_AS(sim.set_state(bad), doctest::Contains("point_velocity[7] = nan m/s: must be finite"),
                         InvalidArgument);
  }
  SUBCASE("in the state before") {
    bad.time_step = 0.0;
    CHECK_THROWS_AS(sim.resume(bad, 1e300, good), InvalidArgument);
  }
  CHECK(sim.state() == good);
}

TEST_CASE("the target of a scripted body is where it goes or rests, and is in the state") {
  Scene scene;
  const BodyId plate = scene.add_rigid({.mesh = make_box({1, 1, 0.1}),
                                        .motion = Motion::Scripted,
                                        .position = {1, 2, 3},
                                        .velocity = {0.5, 0, 0}});
  Simulation sim(scene);
  advance(sim, 1);
  CHECK(sim.target_pose(plate).first.x == sim.position(plate).x);  // at constant velocity: where it is
  const Mat3 turned = exp_rotation({0.1, 0.2, 0.3});
  sim.set_pose(plate, {1, 2, 4}, turned);
  const State state = sim.state();
  for (int n = 0; n < 2; ++n) {
    const auto [x, R] = sim.target_pose(plate);
    CHECK(x.z == 4.0);
    CHECK(max_abs((R - turned) * Vec3{1, 1, 1}) < 1e-15);
    advance(sim, 1);
  }
  Simulation other(scene);
  other.set_state(state);
  CHECK(other.target_pose(plate).first.z == 4.0);
}

TEST_CASE("reset goes back to the start, bit for bit, whatever was released or set meanwhile") {
  const Scene scene = falling_scene();
  Simulation sim(scene);
  const State start = sim.state();
  advance(sim, 3);
  const State third = sim.state();
  sim.reset();
  CHECK(sim.state() == start);
  CHECK(sim.contacts().empty());
  CHECK(sim.acceleration(scene.find("box"), {}).z == 0.0);
  advance(sim, 3);
  CHECK(sim.state() == third);
}
