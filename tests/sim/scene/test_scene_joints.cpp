// Joints: held within tolerance between all kinds of carriers, reactions, coordinates, enabling, refusals.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include <stark/stark.h>

using namespace stark;
using doctest::Approx;

namespace {

RigidDescription cube(const Vec3& position, double mass = 1.0) {
  return {.mesh = make_box({0.1, 0.1, 0.1}), .mass = mass, .position = position};
}

Settings no_contact(double h = 0.01) {
  Settings settings;
  settings.time.step = h;
  settings.contact.enabled = false;
  return settings;
}

ParameterValues values_of(const JointDefinition& definition, double length) {
  ParameterValues values;
  for (const ParameterDeclaration& field : joint_parameters(definition)) values[field.name] = {{length}};
  return values;
}

double largest(const std::vector<double>& values) {
  double result = 0.0;
  for (const double v : values) result = std::max(result, std::fabs(v));
  return result;
}

/// Frames of both sides at a common anchor; b is 0.3 m off where the joint keeps a distance.
struct Pose {
  Vec3 anchor{0.2, 0.0, 0.0};
  Mat3 rotation = exp_rotation({0.3, -0.8, 0.5});
};

}  // namespace

TEST_CASE("every joint holds between two bodies, a body and the world, a body and a patch of cloth") {
  for (const auto& definition : registered_joints()) {
    for (int carrier = 0; carrier < 3; ++carrier) {
      CAPTURE(definition->name);
      CAPTURE(carrier);
      const Pose pose;
      const double length = definition->name == "distance" ? 0.3 : 0.0;
      Scene scene;
      const BodyId b = scene.add_rigid(cube({0.4, 0.0, 0.0}));
      const FrameDescription frame_b =
          body_frame(b, pose.anchor + Vec3{length, 0, 0} - Vec3{0.4, 0.0, 0.0}, pose.rotation);
      FrameDescription frame_a = world_frame(pose.anchor, pose.rotation);
      if (carrier == 1) {
        const BodyId a = scene.add_rigid(cube({0.0, 0.0, 0.0}, 2.0));
        frame_a = body_frame(a, pose.anchor, pose.rotation);
      }
      if (carrier == 2) {
        ShellMaterial stiff = materials::cotton();
        stiff.density = 5.0;
        const BodyId a = scene.add_cloth({.mesh = make_grid(0.4, 0.4, 4, 4), .material = stiff});
        const int32_t pins[] = {0, 4, 20, 24};
        scene.pin(a, pins);
        frame_a = patch_frame(a, {12, 13, 18}, pose.anchor, pose.rotation);
      }
      const JointId joint = scene.add_joint(
          {.definition = definition, .a = frame_a, .b = frame_b, .values = values_of(*definition, length)});
      Simulation simulation(scene, no_contact());
      for (int n = 0; n < 30; ++n) {
        const StepReport& report = simulation.step();
        REQUIRE_MESSAGE(report.status == StepStatus::Accepted, report.message);
        CHECK(largest(simulation.joint_residuals(joint)) < 1e-5);
        // Most where a cube whips about a point on an axis, 0.24 rad in a step.
        CHECK(report.solve.iterations < 40);
      }
    }
  }
}

TEST_CASE("a pendulum hangs from its joint: period, reaction, angle") {
  // Compound pendulum: cube of edge a at distance L, small swing: T = 2 pi sqrt((I + m L^2) / (m g L)).
  const double L = 1.0, a = 0.1, g = 9.81, amplitude = 0.05;
  Scene scene;
  const BodyId bob = scene.add_rigid(cube({L * std::sin(amplitude), 0.0, -L * std::cos(amplitude)}));
  const Mat3 about_y = exp_rotation({-0.5 * std::numbers::pi, 0, 0});  // z axis of the hinge along world y
  const Vec3 pivot{-L * std::sin(amplitude), 0.0, L * std::cos(amplitude)};
  const JointId hinge = scene.add_joint({.definition = find_joint("hinge"),
                                         .a = world_frame({0, 0, 0}, about_y),
                                         .b = body_frame(bob, pivot, about_y)});
  Simulation simulation(scene, no_contact(1e-3));
  double crossing = 0.0, last = simulation.position(bob).x;
  int crossings = 0;
  std::vector<double> times;
  while (crossings < 3 && simulation.time() < 5.0) {
    REQUIRE_FALSE(simulation.step().failed());
    const double x = simulation.position(bob).x;
    if (x * last < 0.0) {
      crossing = simulation.time() - 1e-3 * x / (x - last);
      times.push_back(crossing);
      ++crossings;
    }
    last = x;
  }
  REQUIRE(times.size() == 3);
  const double inertia = a * a / 6.0 + L * L;
  CHECK(times[2] - times[0] == Approx(2.0 * std::numbers::pi * std::sqrt(inertia / (g * L))).epsilon(2e-3));
  // Near the lowest point the joint carries the weight and the small centripetal force.
  CHECK(simulation.joint_reaction(hinge).force.z == Approx(g).epsilon(0.01));
  CHECK(norm(simulation.joint_reaction(hinge).torque) < 1e-3);
  const double angle = simulation.joint_coordinates(hinge)[0];
  CHECK(std::fabs(angle) == Approx(amplitude).epsilon(0.2));
}

TEST_CASE("angles count full turns") {
  Scene scene;
  RigidDescription wheel = cube({0, 0, 0});
  wheel.angular_velocity = {0, 0, 20.0};
  const BodyId body = scene.add_rigid(wheel);
  const JointId hinge = scene.add_joint(
      {.definition = find_joint("hinge"), .a = world_frame({0, 0, 0}), .b = body_frame(body, {0, 0, 0})});
  Settings settings = no_contact(1e-3);
  settings.gravity = {};
  Simulation simulation(scene, settings);
  double turned = 0.0;
  for (int n = 0; n < 1000; ++n) {
    REQUIRE_FALSE(simulation.step().failed());
    turned += 1e-3 * simulation.angular_velocity(body).z;
  }
  CHECK(turned > 2.0 * 2.0 * std::numbers::pi);
  CHECK(simulation.joint_coordinates(hinge)[0] == Approx(turned).epsilon(1e-3));
  CHECK(simulation.joint_coordinate_names(hinge)[0].name == "angle");
}

TEST_CASE("the reaction of a weld carries weight and moment of a cantilever") {
  Scene scene;
  const BodyId body = scene.add_rigid(cube({0.5, 0, 0}, 2.0));
  const JointId weld = scene.add_joint(
      {.definition = find_joint("fixed"), .a = world_frame({0, 0, 0}), .b = body_frame(body, {-0.5, 0, 0})});
  Simulation simulation(scene, no_contact());
  for (int n = 0; n < 5; ++n) REQUIRE_FALSE(simulation.step().failed());
  const Wrench wrench = simulation.joint_reaction(weld);
  CHECK(wrench.force.z == Approx(2.0 * 9.81).epsilon(1e-6));
  CHECK(wrench.torque.y == Approx(-2.0 * 9.81 * 0.5).epsilon(1e-6));
  CHECK(norm(Vec3{wrench.force.x, wrench.force.y, 0.0}) < 1e-6);
}

TEST_CASE("fifty links hang, swing and stay together") {
  Scene scene;
  std::vector<JointId> joints;
  BodyId previous{};
  for (int k = 0; k < 50; ++k) {
    const BodyId link = scene.add_rigid(
        {.mesh = make_box({0.1, 0.02, 0.02}), .mass = 0.1, .position = {0.05 + 0.1 * k, 0.0, 0.0}});
    joints.push_back(
        scene.add_joint({.definition = find_joint("ball"),
                         .a = k == 0 ? world_frame({0, 0, 0}) : body_frame(previous, {0.05, 0, 0}),
                         .b = body_frame(link, {-0.05, 0, 0})}));
    previous = link;
  }
  Simulation simulation(scene, no_contact(1.0 / 60.0));
  int iterations = 0;
  for (int n = 0; n < 120; ++n) {
    const StepReport& report = simulation.step();
    REQUIRE_MESSAGE(report.status == StepStatus::Accepted, report.message);
    iterations += report.solve.iterations;
    for (const JointId joint : joints) CHECK(largest(simulation.joint_residuals(joint)) <= 1e-6);
  }
  MESSAGE("iterations per step: " << iterations / 120.0);
}

TEST_CASE("closed loops with redundant joints and mass ratios of ten thousand hold for long") {
  // Four bars of a parallelogram with hinges about y: planar, so that three rows of each loop are redundant.
  Scene scene;
  const Mat3 about_y = exp_rotation({-0.5 * std::numbers::pi, 0, 0});
  const auto bar = [&](const Vec3& from, const Vec3& to, double mass) {
    const Vec3 d = to - from;
    return scene.add_rigid({.mesh = make_box({0.05, 0.05, norm(d)}),
                            .mass = mass,
                            .position = (from + to) * 0.5,
                            .rotation = std::fabs(d.z) > std::fabs(d.x)
                                            ? Mat3::identity()
                                            : exp_rotation({0, 0.5 * std::numbers::pi, 0})});
  };
  const Vec3 A{0, 0, 0}, B{1, 0, 0}, C{1, 0, -1}, D{0, 0, -1};
  const BodyId left = bar(A, D, 1e-2), right = bar(B, C, 1e-2), low = bar(D, C, 100.0);
  std::vector<JointId> joints;
  const auto hinge = [&](std::optional<BodyId> a, BodyId b, const Vec3& anchor) {
    const auto frame = [&](BodyId body) {
      const RigidDescription& r = scene.rigid(body);
      return body_frame(body, transpose(r.rotation) * (anchor - r.position), transpose(r.rotation) * about_y);
    };
    joints.push_back(scene.add_joint({.definition = find_joint("hinge"),
                                      .a = a ? frame(*a) : world_frame(anchor, about_y),
                                      .b = frame(b)}));
  };
  hinge({}, left, A);
  hinge({}, right, B);
  hinge(left, low, D);
  hinge(right, low, C);
  Settings settings = no_contact(0.01);
  settings.gravity = {2.0, 0.0, -9.81};
  Simulation simulation(scene, settings);
  double largest_multiplier = 0.0;
  for (int n = 0; n < 400; ++n) {
    const StepReport& report = simulation.step();
    REQUIRE_MESSAGE(report.status == StepStatus::Accepted, report.message);
    for (const JointId joint : joints) CHECK(largest(simulation.joint_residuals(joint)) <= 1e-5);
    largest_multiplier = std::max(largest_multiplier, largest(simulation.state().joint_multiplier));
  }
  CHECK(largest_multiplier < 5e3);  // 100 kg swinging: about 1e3 N on each bar
}

TEST_CASE("a joint can be released and held again") {
  Scene scene;
  const BodyId body = scene.add_rigid(cube({0, 0, 0}));
  const JointId joint = scene.add_joint(
      {.definition = find_joint("ball"), .a = world_frame({0, 0, 0}), .b = body_frame(body, {0, 0, 0})});
  Simulation simulation(scene, no_contact());
  for (int n = 0; n < 10; ++n) REQUIRE_FALSE(simulation.step().failed());
  CHECK(std::fabs(simulation.position(body).z) < 1e-6);
  simulation.set_joint_enabled(joint, false);
  for (int n = 1; n <= 10; ++n) REQUIRE_FALSE(simulation.step().failed());
  CHECK(simulation.position(body).z == Approx(-9.81 * 1e-4 * 55).epsilon(1e-4));
  simulation.set_joint_enabled(joint, true);
  REQUIRE_FALSE(simulation.step().failed());
  CHECK(norm(simulation.position(body)) < 1e-6);
}

TEST_CASE("a state goes on with the same bits, joints included") {
  const auto make = [] {
    Scene scene;
    const BodyId a = scene.add_rigid(cube({0, 0, 0})), b = scene.add_rigid(cube({0.3, 0, 0}));
    scene.add_joint(
        {.definition = find_joint("hinge"), .a = world_frame({0, 0, 0}), .b = body_frame(a, {0, 0, 0})});
    scene.add_joint({.definition = find_joint("universal"),
                     .a = body_frame(a, {0.15, 0, 0}),
                     .b = body_frame(b, {-0.15, 0, 0})});
    return scene;
  };
  Simulation first(make(), no_contact());
  for (int n = 0; n < 10; ++n) REQUIRE_FALSE(first.step().failed());
  Simulation second(make(), no_contact());
  second.set_state(first.state());
  for (int n = 0; n < 10; ++n) {
    first.step();
    second.step();
    CHECK(first_difference(first.state(), second.state()) == "");
  }
}

TEST_CASE("joints that contradict each other fail with their name and leave the state as it was") {
  Scene scene;
  const BodyId left = scene.add_rigid({.mesh = make_box({0.1, 0.1, 0.1}), .motion = Motion::Scripted});
  const BodyId body = scene.add_rigid(cube({1, 0, 0}));
  scene.add_joint({.definition = find_joint("ball"),
                   .a = body_frame(left, {0.5, 0, 0}),
                   .b = body_frame(body, {-0.5, 0, 0})});
  scene.add_joint({.name = "to the wall",
                   .definition = find_joint("fixed"),
                   .a = world_frame({1.5, 0, 0}),
                   .b = body_frame(body, {0.5, 0, 0})});
  Settings settings = no_contact();
  settings.time.min_step = 2e-3;
  Simulation simulation(scene, settings);
  REQUIRE_FALSE(simulation.step().failed());
  const State before = simulation.state();
  simulation.set_pose(left, {-0.1, 0, 0}, Mat3::identity());
  const State ordered = simulation.state();
  const StepReport& report = simulation.step();
  CHECK(report.status == StepStatus::Failed);
  CHECK_MESSAGE(report.message.find("is apart by") != std::string::npos, report.message);
  CHECK(first_difference(simulation.state(), ordered) == "");
}

TEST_CASE("joints that cannot be built are refused") {
  Scene scene;
  const BodyId body = scene.add_rigid(cube({0, 0, 0}));
  const BodyId cloth = scene.add_cloth({.mesh = make_grid(0.2, 0.2, 2, 2), .material = materials::cotton()});
  const auto refused = [&](JointDescription joint, const char* text) {
    CHECK_THROWS_WITH_AS(scene.add_joint(std::move(joint)), doctest::Contains(text), InvalidArgument);
    CHECK(scene.joints().empty());
  };
  const auto ball = find_joint("ball");
  refused({.a = world_frame({}), .b = body_frame(body, {})}, "no definition");
  refused({.definition = ball, .a = world_frame({}), .b = world_frame({})}, "both frames are of the world");
  refused({.definition = ball, .a = body_frame(body, {}), .b = body_frame(body, {})},
          "must be of two bodies");
  refused({.definition = ball, .a = world_frame({}), .b = body_frame(cloth, {})}, "only rigid bodies");
  refused({.definition = ball, .a = world_frame({}), .b = patch_frame(body, {0, 1, 2}, {})},
          "is a rigid body");
  refused({.definition = ball, .a = world_frame({}), .b = patch_frame(cloth, {0, 1, 2}, {})}, "no area");
  refused({.definition = ball, .a = world_frame({}), .b = patch_frame(cloth, {0, 1, 9}, {})}, "in [0, 9)");
  refused({.definition = find_joint("distance"), .a = world_frame({}), .b = body_frame(body, {})},
          "'length' [m] is missing");
  refused(
      {.definition = ball, .a = world_frame({}), .b = body_frame(body, {}), .values = {{"length", {{1.0}}}}},
      "unknown value");
  CHECK_THROWS_WITH_AS(find_joint("hing"), doctest::Contains("hinge"), InvalidArgument);
  scene.add_joint({.definition = ball, .a = world_frame({}), .b = body_frame(body, {0.1, 0, 0})});
  CHECK_THROWS_WITH_AS(Simulation(scene, no_contact()), doctest::Contains("differ by 0.1 m at time 0"),
                       InvalidArgument);
}

TEST_CASE("a joint with a limit lets go on one side and carries on the other") {
  // The origin of b stays above the plane z = 0 of a.
  const auto above = std::make_shared<const JointDefinition>(define_joint("above", "", [](JointBuilder& j) {
    j.limit(-symbolic::dot(j.a.z, j.b.origin - j.a.origin), ResidualUnit::Length);
  }));
  Scene scene;
  const BodyId body = scene.add_rigid(cube({0, 0, 0.05}, 2.0));
  const JointId joint =
      scene.add_joint({.definition = above, .a = world_frame({}), .b = body_frame(body, {})});
  Simulation simulation(scene, no_contact());
  REQUIRE(simulation.step().status == StepStatus::Accepted);
  CHECK(norm(simulation.joint_reaction(joint).force) == 0.0);
  CHECK(simulation.linear_velocity(body).z == Approx(-0.0981).epsilon(1e-9));
  for (int n = 0; n < 30; ++n) {
    REQUIRE(simulation.step().status == StepStatus::Accepted);
    CHECK(simulation.position(body).z > -1e-6);
  }
  CHECK(simulation.joint_reaction(joint).force.z == Approx(2.0 * 9.81).epsilon(1e-6));
}
