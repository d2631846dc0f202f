// Placing of bodies between steps: what is refused, what starts anew and what goes on, energy, orders of
// convergence, joints.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include <stark/base/error.h>
#include <stark/base/rotation.h>
#include <stark/geometry/shapes.h>
#include <stark/sim/scene/registry.h>
#include <stark/sim/simulation.h>
#include <stark/sim/step/placing.h>

using namespace stark;

namespace {

Scene two_boxes() {
  Scene scene;
  scene.add_rigid({.name = "floor", .mesh = make_box({2, 2, 0.1}), .motion = Motion::Fixed});
  for (const char* name : {"left", "right"})
    scene.add_rigid({.name = name,
                     .mesh = make_box({0.1, 0.1, 0.1}),
                     .mass = 0.2,
                     .position = {name[0] == 'l' ? 0.0 : 0.3, 0, 0.1005},
                     .velocity = {0.1, 0, 0}});
  return scene;
}

void advance(Simulation& sim, int steps) {
  for (int n = 0; n < steps; ++n) REQUIRE_FALSE(sim.step().failed());
}

Settings with(Integrator integrator, double step) {
  Settings settings;
  settings.time.integrator = integrator;
  settings.time.step = step;
  return settings;
}

}  // namespace

TEST_CASE("what is refused leaves the state and the sensors as they were") {
  const Scene scene = two_boxes();
  Simulation sim(scene);
  advance(sim, 3);
  const State before = sim.state();
  const BodyId left = scene.find("left");
  const size_t contacts = sim.contacts().size();
  REQUIRE(contacts > 0);
  CHECK_THROWS_WITH_AS(sim.place(left, {0.31, 0, 0.2}, Mat3::identity()),
                       doctest::Contains("'left' and 'right' intersect as placed"), InitialIntersection);
  CHECK_THROWS_AS(sim.place(left, {0, 0, NAN}, Mat3::identity()), InvalidArgument);
  CHECK_THROWS_AS(sim.place(left, {0, 0, 1}, Mat3{}), InvalidArgument);
  CHECK_THROWS_AS(sim.place_vertices(left, std::vector<Vec3>(8)), InvalidArgument);
  CHECK_THROWS_WITH_AS(sim.place(scene.find("floor"), {0, 0, 1}, Mat3::identity()),
                       doctest::Contains("must be dynamic"), InvalidArgument);
  CHECK(sim.state() == before);
  CHECK(sim.placed().bodies.empty());
  CHECK(sim.contacts().size() == contacts);
}

TEST_CASE("bodies change places together, one after the other they would meet") {
  const Scene scene = two_boxes();
  Simulation sim(scene);
  advance(sim, 2);
  const BodyId left = scene.find("left"), right = scene.find("right");
  const Vec3 a = sim.position(left), b = sim.position(right);
  const State before = sim.state();
  CHECK_THROWS_AS(sim.place(left, b, Mat3::identity()), InitialIntersection);
  sim.begin_placing();
  sim.place(left, b, Mat3::identity());
  CHECK_THROWS_AS(sim.step(), InvalidArgument);
  CHECK_THROWS_AS(sim.reset(), InvalidArgument);
  CHECK_THROWS_AS(sim.begin_placing(), InvalidArgument);
  sim.cancel_placing();
  CHECK(sim.state() == before);
  sim.begin_placing();
  sim.place(left, b, Mat3::identity());
  sim.place(right, a, Mat3::identity());
  sim.end_placing();
  CHECK(sim.position(left).x == b.x);
  CHECK(sim.placed().bodies == std::vector<int32_t>{left.index, right.index});
  CHECK(sim.contacts().empty());
  advance(sim, 1);
  CHECK(sim.report().placed == std::vector<int32_t>{left.index, right.index});
  CHECK(sim.placed().bodies.empty());
  advance(sim, 1);
  CHECK(sim.report().placed.empty());
}

TEST_CASE("what is put where it is, with the velocity that it has, goes on as it was") {
  Scene scene = two_boxes();
  scene.set_default_friction(0.8);
  const BodyId sheet =
      scene.add_cloth({.name = "sheet", .mesh = make_grid(0.2, 0.2, 2, 2), .position = {0, 0.5, 0.06}});
  const BodyId left = scene.find("left");
  const BodyId gate = scene.add_rigid({.name = "gate",
                                       .mesh = make_box({0.1, 0.1, 0.1}),
                                       .mass = 0.1,
                                       .position = {0, -0.5, 0.5},
                                       .angular_velocity = {0, 0, 1}});
  const JointId hinge = scene.add_joint(
      {.definition = find_joint("hinge"), .a = world_frame({0, -0.5, 0.5}), .b = body_frame(gate, {})});
  for (const Integrator integrator : {Integrator::ImplicitEuler, Integrator::Bdf2}) {
    Simulation sim(scene, with(integrator, 0.01));
    advance(sim, 5);
    const State before = sim.state();
    REQUIRE(!before.friction_pair.empty());
    const size_t contacts = sim.contacts().size();
    sim.place(left, sim.position(left), sim.rotation(left));
    sim.push(left, sim.centre_velocity(left), sim.angular_velocity(left));
    sim.place_vertices(sheet, sim.positions(sheet));
    sim.push_vertices(sheet, sim.velocities(sheet));
    sim.place_joint(hinge, sim.joint_coordinates(hinge));
    sim.push_joint(hinge, sim.joint_rates(hinge));
    CHECK(sim.state() == before);
    CHECK(sim.contacts().size() == contacts);
    CHECK(sim.placed().bodies.empty());
    sim.push(left, sim.centre_velocity(left) + Vec3{0, 0, 1e-12}, sim.angular_velocity(left));
    CHECK(sim.placed().bodies == std::vector<int32_t>{left.index});
  }
}

TEST_CASE("friction and impacts of what was moved end, those of the rest go on") {
  const Scene scene = [] {
    Scene s = two_boxes();
    s.set_default_friction(0.8);
    return s;
  }();
  Simulation sim(scene);
  advance(sim, 6);
  const State before = sim.state();
  REQUIRE(before.friction_pair.size() > 4);
  sim.place(scene.find("left"), {0, 0.5, 0.3}, Mat3::identity());
  const State& after = sim.state();
  CHECK(after.friction_pair.size() < before.friction_pair.size());
  REQUIRE(!after.friction_pair.empty());
  for (size_t k = 0; k < after.friction_pair.size(); ++k)  // what is left is as it was
    CHECK(std::ranges::find(before.friction_pair, after.friction_pair[k]) != before.friction_pair.end());
  const auto right = static_cast<size_t>(sim.model().bodies()[scene.find("right").index].rigid_index);
  CHECK(after.body_velocity[right].x == before.body_velocity[right].x);
  CHECK(after.body_position[right].z == before.body_position[right].z);
}

TEST_CASE("the report names the energy that placing gave: lifted and pushed bodies") {
  const Scene scene = two_boxes();
  Simulation sim(scene);
  advance(sim, 2);
  const BodyId left = scene.find("left");
  const double stored = sim.report().energy.stored() - sim.report().energy.contact;
  const Vec3 x = sim.position(left);
  sim.place(left, x + Vec3{0, 0, 0.5}, Mat3::identity());
  sim.push(left, {0, 0, 2}, {});
  const double lifted = 0.2 * -sim.settings().gravity.z * 0.5;
  advance(sim, 1);
  const double kinetic = 0.5 * 0.2 * 4.0;
  CHECK(sim.report().energy.placed == doctest::Approx(lifted + kinetic).epsilon(0.02));
  const EnergyLedger& e = sim.report().energy;
  const double change = e.stored() - e.contact - stored;
  const double supplied = e.placed + e.external + e.actuation + e.restitution - e.damping - e.friction -
                          e.numerical - (e.contact - sim.report().contact_energy_at_start);
  CHECK(change == doctest::Approx(supplied).epsilon(1e-9));
}

TEST_CASE("with BDF2, what is placed falls as exactly as what fell from the start") {
  Scene scene;
  const BodyId ball = scene.add_rigid({.name = "ball", .mesh = make_icosphere(0.1, 1), .mass = 1.0});
  ShellMaterial undamped = materials::cotton();
  undamped.mass_damping = 0.0;
  const BodyId cloth = scene.add_cloth(
      {.name = "cloth", .mesh = make_grid(0.1, 0.1, 2, 2), .material = undamped, .position = {5, 0, 0}});
  Simulation sim(scene, with(Integrator::Bdf2, 0.01));
  advance(sim, 7);
  const double g = sim.settings().gravity.z;
  sim.begin_placing();
  sim.place(ball, {1, 2, 3}, exp_rotation({0.3, 0, 0}));
  sim.push(ball, {1, 0, 2}, {0, 0, 3});
  sim.place_vertices(cloth, [&] {
    std::vector<Vec3> x = sim.positions(cloth);
    for (Vec3& p : x) p += Vec3{0, 0, 2};
    return x;
  }());
  sim.push_vertices(cloth, std::vector<Vec3>(9, Vec3{0, 0, 1}));
  sim.end_placing();
  const double cloth_height = sim.positions(cloth)[4].z;
  const double start = sim.time();
  advance(sim, 10);
  CHECK(sim.report().integrator == Integrator::Bdf2);
  const double t = sim.time() - start;
  CHECK(sim.linear_velocity(ball).z == doctest::Approx(2 + g * t).epsilon(1e-9));
  CHECK(sim.position(ball).z == doctest::Approx(3 + 2 * t + 0.5 * g * t * t).epsilon(1e-9));
  CHECK(sim.position(ball).x == doctest::Approx(1 + t).epsilon(1e-9));
  CHECK(sim.angular_velocity(ball).z == doctest::Approx(3.0).epsilon(1e-9));
  CHECK(sim.positions(cloth)[4].z == doctest::Approx(cloth_height + t + 0.5 * g * t * t).epsilon(1e-6));
}

TEST_CASE("a push keeps the forces that act: BDF2 goes on with order 2 on a spring") {
  // A ball on a servo's spring is pushed at t = 0.1 s; compared with the same in finer steps.
  const auto displacement = [](double h) {
    Scene scene;
    const BodyId ball = scene.add_rigid({.name = "ball", .mesh = make_icosphere(0.1, 1), .mass = 1.0});
    const JointId slider =
        scene.add_joint({.definition = find_joint("slider"),
                         .a = world_frame({}, exp_rotation({0, 0.5 * 3.14159265358979323846, 0})),
                         .b = body_frame(ball, {}, exp_rotation({0, 0.5 * 3.14159265358979323846, 0}))});
    scene.add_actuator({.definition = find_actuator("spring_damper"),
                        .on = {{slider, ""}},
                        .values = {{"stiffness", 300.0}, {"damping", 0.0}, {"rest", 0.05}}});
    Settings settings = with(Integrator::Bdf2, h);
    settings.newton.residual_tolerance = 1e-10;
    Simulation sim(scene, settings);
    while (sim.time() < 0.1 - 1e-9) REQUIRE_FALSE(sim.step().failed());
    sim.push(ball, sim.linear_velocity(ball) + Vec3{0.4, 0, 0}, {});
    while (sim.time() < 0.3 - 1e-9) REQUIRE_FALSE(sim.step().failed());
    return sim.position(ball).x;
  };
  const double exact = displacement(0.1 / 800);
  const double coarse = std::fabs(displacement(0.1 / 25) - exact);
  const double fine = std::fabs(displacement(0.1 / 50) - exact);
  CHECK(coarse / fine > 3.3);
}

TEST_CASE("a coordinate of a chain moves what hangs on the joint, and keeps all rates") {
  Scene scene;
  std::vector<BodyId> links;
  std::vector<JointId> hinges;
  const Mat3 across = exp_rotation({-0.5 * 3.14159265358979323846, 0, 0});  // z of the frames along y
  for (int k = 0; k < 3; ++k) {
    links.push_back(scene.add_rigid({.name = "link" + std::to_string(k),
                                     .mesh = make_box({0.18, 0.02, 0.02}),
                                     .mass = 0.1,
                                     .position = {0.2 * k + 0.1, 0, 1}}));
    const FrameDescription a =
        k == 0 ? world_frame({0, 0, 1}, across) : body_frame(links[k - 1], {0.1, 0, 0}, across);
    hinges.push_back(scene.add_joint(
        {.definition = find_joint("hinge"), .a = a, .b = body_frame(links[k], {-0.1, 0, 0}, across)}));
  }
  Simulation sim(scene, with(Integrator::ImplicitEuler, 0.01));
  advance(sim, 10);
  const std::vector<double> before{sim.joint_coordinates(hinges[0])[0], sim.joint_coordinates(hinges[2])[0]};
  const Vec3 root = sim.position(links[0]);
  const double target[] = {7.5};
  sim.place_joint(hinges[1], target);
  CHECK(sim.joint_coordinates(hinges[1])[0] == doctest::Approx(7.5).epsilon(1e-12));
  CHECK(sim.joint_coordinates(hinges[0])[0] == doctest::Approx(before[0]).epsilon(1e-12));
  CHECK(sim.joint_coordinates(hinges[2])[0] == doctest::Approx(before[1]).epsilon(1e-9));
  CHECK(norm(sim.position(links[0]) - root) == 0.0);
  for (const JointId hinge : hinges)
    for (const double r : sim.joint_residuals(hinge)) CHECK(std::fabs(r) < 1e-7);
  CHECK(sim.placed().bodies == std::vector<int32_t>{links[1].index, links[2].index});
  const double rate[] = {4.0};
  const std::vector<double> rates{sim.joint_rates(hinges[0])[0], sim.joint_rates(hinges[2])[0]};
  sim.push_joint(hinges[1], rate);
  CHECK(sim.joint_rates(hinges[1])[0] == doctest::Approx(4.0).epsilon(1e-7));
  CHECK(sim.joint_rates(hinges[0])[0] == doctest::Approx(rates[0]).epsilon(1e-7));
  CHECK(sim.joint_rates(hinges[2])[0] == doctest::Approx(rates[1]).epsilon(1e-7));
  advance(sim, 1);
  CHECK(sim.joint_coordinates(hinges[1])[0] == doctest::Approx(7.54).epsilon(1e-2));
  CHECK_THROWS_WITH_AS(sim.place(links[1], {0, 0, 2}, Mat3::identity()), doctest::Contains("is apart by"),
                       InvalidArgument);
}

TEST_CASE("coordinates of loops and of released joints are refused") {
  Scene scene;
  const BodyId bar = scene.add_rigid({.name = "bar", .mesh = make_box({0.2, 0.02, 0.02}), .mass = 0.1});
  const JointId first = scene.add_joint({.definition = find_joint("hinge"),
                                         .a = world_frame({-0.1, 0, 0}),
                                         .b = body_frame(bar, {-0.1, 0, 0})});
  const JointId second = scene.add_joint({.definition = find_joint("cylindrical"),
                                          .a = world_frame({-0.1, 0, 0}),
                                          .b = body_frame(bar, {-0.1, 0, 0})});
  Simulation sim(scene);
  const State before = sim.state();
  const double angle[] = {0.5};
  CHECK_THROWS_WITH_AS(sim.place_joint(first, angle), doctest::Contains("neither side hangs on it alone"),
                       InvalidArgument);
  sim.set_joint_enabled(second, false);
  sim.place_joint(first, angle);
  CHECK(sim.joint_coordinates(first)[0] == doctest::Approx(0.5));
  const double both[] = {0.5, 0.0};
  CHECK_THROWS_WITH_AS(sim.place_joint(second, both), doctest::Contains("is released"), InvalidArgument);
  CHECK_THROWS_AS(sim.place_joint(first, both), InvalidArgument);
  CHECK_FALSE(sim.state() == before);
}

TEST_CASE("bodies of all kinds are placed as one; what is pinned or clamped rests where it comes to") {
  Scene scene;
  const RodMaterial wire{.density = 1000, .youngs_modulus = 1e6, .radius = 0.002};
  const std::vector<Vec3> nodes{{0, 0, 0}, {0.1, 0, 0}, {0.2, 0, 0}, {0.3, 0, 0}};
  const BodyId rod = scene.add_rod({.name = "rod", .mesh = {nodes}, .material = wire});
  scene.clamp(rod, std::vector<int32_t>{0});
  const BodyId cloth =
      scene.add_cloth({.name = "cloth", .mesh = make_grid(0.2, 0.2, 2, 2), .position = {0, 1, 0}});
  scene.pin(cloth, std::vector<int32_t>{0});
  const BodyId wall = scene.add_rigid(
      {.name = "wall", .mesh = make_box({0.1, 0.1, 0.1}), .motion = Motion::Fixed, .position = {0, 0, 5}});
  Settings settings = with(Integrator::ImplicitEuler, 0.01);
  settings.gravity = {};
  Simulation sim(scene, settings);
  const Mat3 turn = exp_rotation({0.3, -1.0, 0.7});
  const Vec3 shift{0.5, 1.0, -2.0};
  const auto moved = [&](std::vector<Vec3> x) {
    for (Vec3& p : x) p = turn * p + shift;
    return x;
  };
  const auto goal_rod = moved(sim.positions(rod)), goal_cloth = moved(sim.positions(cloth));
  const std::vector<int32_t> both{rod.index, cloth.index};
  sim.place_together(both, turn, shift);
  advance(sim, 3);
  for (size_t k = 0; k < goal_rod.size(); ++k) CHECK(norm(sim.positions(rod)[k] - goal_rod[k]) < 1e-9);
  for (size_t k = 0; k < goal_cloth.size(); ++k) CHECK(norm(sim.positions(cloth)[k] - goal_cloth[k]) < 1e-9);
  const State before = sim.state();
  const std::vector<int32_t> held{rod.index, wall.index};
  CHECK_THROWS_WITH_AS(sim.place_together(held, turn, shift), doctest::Contains("'wall' is fixed"),
                       InvalidArgument);
  CHECK_THROWS_AS(sim.place_together(both, Mat3{}, shift), InvalidArgument);
  CHECK(sim.state() == before);
}
