// Whole simulations against closed forms and conservation laws; determinism, rewinding, refused initial
// states.
#include <doctest/doctest.h>

#include <numbers>

#include <stark/base/error.h>
#include <stark/base/rotation.h>
#include <stark/geometry/shapes.h>
#include <stark/sim/simulation.h>
#include <support/simulation_checks.h>

using namespace stark;
using namespace stark::test;

namespace {

Settings quiet_settings(double h) {
  Settings settings;
  settings.time.step = h;
  settings.time.min_step = std::min(settings.time.min_step, h);
  settings.linear.solver = "cholesky";
  return settings;
}

/// Material without damping.
ShellMaterial plain_shell() { return {.density = 0.2, .youngs_modulus = 5e3, .bending_stiffness = 1e-6}; }

/// Implicit Euler with constant acceleration: v_n = v_0 + n h g, x_n = x_0 + n h v_0 + n (n + 1)/2 h^2 g.
Vec3 fallen(const Vec3& x0, const Vec3& v0, const Vec3& g, double h, int n) {
  return x0 + v0 * (n * h) + g * (0.5 * n * (n + 1) * h * h);
}

/// A scene of everything in contact: cloth over a fixed sphere, a soft box and a rigid box on the cloth.
Scene contact_scene() {
  Scene scene;
  scene.set_default_friction(0.5);
  scene.add_rigid({.name = "sphere",
                   .mesh = make_icosphere(0.1, 1),
                   .motion = Motion::Fixed,
                   .position = {0.01, 0.02, -0.105}});
  scene.add_cloth({.name = "cloth", .mesh = make_grid(0.4, 0.4, 8, 8), .material = materials::cotton()});
  scene.add_rigid({.name = "box",
                   .mesh = make_box({0.04, 0.05, 0.06}),
                   .mass = 0.02,
                   .position = {0.03, 0.0, 0.04},
                   .velocity = {0, 0, -1},
                   .angular_velocity = {1, 2, 3}});
  scene.add_solid({.name = "soft",
                   .mesh = make_tet_box({0.04, 0.04, 0.04}, {1, 1, 1}),
                   .material = materials::soft_rubber(),
                   .position = {-0.04, 0.01, 0.03},
                   .velocity = {0, 0, -1}});
  return scene;
}

Settings contact_settings() {
  Settings settings = quiet_settings(0.01);
  settings.contact.distance = 2e-3;
  return settings;
}

/// Angular velocity and momentum in the body frame by the classical Runge-Kutta method on Euler's equations.
Vec3 euler_equations(const Vec3& J, Vec3 w, double T) {
  const auto rate = [&](const Vec3& u) {
    return Vec3{(J.y - J.z) / J.x * u.y * u.z, (J.z - J.x) / J.y * u.z * u.x, (J.x - J.y) / J.z * u.x * u.y};
  };
  const int n = 20000;
  const double h = T / n;
  for (int k = 0; k < n; ++k) {
    const Vec3 a = rate(w), b = rate(w + a * (0.5 * h)), c = rate(w + b * (0.5 * h)), d = rate(w + c * h);
    w += (a + b * 2.0 + c * 2.0 + d) * (h / 6.0);
  }
  return w;
}

}  // namespace

TEST_CASE("free fall of cloth, solid and rigid body is the closed form of implicit Euler") {
  Scene scene;
  const Vec3 v{0.3, -0.2, 1.0};
  const BodyId cloth =
      scene.add_cloth({.mesh = make_grid(0.3, 0.3, 3, 3), .material = plain_shell(), .velocity = v});
  const BodyId solid = scene.add_solid(
      {.mesh = make_tet_box({0.1, 0.1, 0.1}, {2, 1, 1}), .position = {1, 0, 0}, .velocity = v});
  const BodyId box =
      scene.add_rigid({.mesh = make_box({0.1, 0.2, 0.3}), .mass = 2.0, .position = {2, 0, 0}, .velocity = v});
  const double h = 0.01;
  Simulation sim(scene, quiet_settings(h));
  const std::vector<Vec3> cloth_0 = sim.positions(cloth), solid_0 = sim.positions(solid),
                          box_0 = sim.positions(box);
  const Vec3 g = sim.settings().gravity;
  for (int n = 1; n <= 20; ++n) {
    REQUIRE(sim.step().status == StepStatus::Accepted);
    CHECK(sim.time() == doctest::Approx(n * h).epsilon(1e-14));
    double worst = 0.0;  // [m]; positions are of order one, twenty steps round a few times each
    const auto compare = [&](BodyId body, const std::vector<Vec3>& start) {
      const std::vector<Vec3> x = sim.positions(body);
      for (size_t i = 0; i < x.size(); ++i)
        worst = std::fmax(worst, max_abs(x[i] - fallen(start[i], v, g, h, n)));
    };
    compare(cloth, cloth_0);
    compare(solid, solid_0);
    compare(box, box_0);
    CHECK(worst < 1e-12);
  }
  CHECK(max_abs(sim.linear_velocity(box) - (v + g * (20 * h))) < 1e-11);
}

TEST_CASE("mass damping slows free motion by 1 / (1 + a h) a step") {
  Scene scene;
  const BodyId box = scene.add_rigid(
      {.mesh = make_box({0.1, 0.1, 0.1}), .mass = 1.0, .velocity = {1, 0, 0}, .linear_damping = 3.0});
  ShellMaterial damped = plain_shell();
  damped.mass_damping = 3.0;
  const BodyId cloth = scene.add_cloth(
      {.mesh = make_grid(0.1, 0.1, 2, 2), .material = damped, .position = {0, 0, 1}, .velocity = {1, 0, 0}});
  Settings settings = quiet_settings(0.02);
  settings.gravity = {};
  Simulation sim(scene, settings);
  for (int n = 1; n <= 10; ++n) {
    REQUIRE_FALSE(sim.step().failed());
    const double expected = std::pow(1.0 + 3.0 * 0.02, -n);
    CHECK(sim.linear_velocity(box).x == doctest::Approx(expected).epsilon(1e-11));
    CHECK(sim.velocities(cloth)[4].x == doctest::Approx(expected).epsilon(1e-11));
  }
}

TEST_CASE("a torque-free asymmetric body moves by Euler's equations and keeps its angular momentum") {
  const Vec3 omega{0.5, 6.0, 0.3};  // near the unstable middle axis
  const double T = 0.4;
  for (const auto& [integrator, h] : {std::pair{Integrator::ImplicitEuler, 0.02},
                                      {Integrator::ImplicitEuler, 0.002},
                                      {Integrator::Bdf2, 0.02}}) {
    Scene scene;
    scene.add_rigid({.mesh = make_box({0.1, 0.2, 0.3}), .mass = 2.0, .angular_velocity = omega});
    Settings settings = quiet_settings(h);
    settings.time.integrator = integrator;
    settings.gravity = {};
    Simulation sim(scene, settings);
    const Vec3 before = spin(sim, 0);
    const Mat3 R0 = sim.state().body_rotation[0];
    for (int n = 0; n < static_cast<int>(std::lround(T / h)); ++n) REQUIRE_FALSE(sim.step().failed());
    CHECK(norm(spin(sim, 0) - before) < 1e-13 * norm(before));
    const Vec3 start = transpose(R0) * omega;
    const Vec3 exact = euler_equations(sim.model().rigid_masses()[0].moments, start, T);
    const Vec3 body_rate = transpose(sim.state().body_rotation[0]) * sim.angular_velocity({0});
    CHECK(norm(exact - start) > 1.0);  // without gyroscopic torque the rate would not change [rad/s]
    // Substeps of 0.05 rad of a rule of second order, near an axis whose disturbances grow by e^2 in T.
    CHECK(norm(body_rate - exact) < 2e-4 * norm(exact - start));
  }
}

TEST_CASE("a symmetric body spins on about its axis") {
  Scene scene;
  scene.add_rigid({.mesh = make_cylinder(0.1, 0.05, 16), .mass = 1.0, .angular_velocity = {0, 0, 5}});
  Settings settings = quiet_settings(0.01);
  settings.gravity = {};
  Simulation sim(scene, settings);
  for (int n = 0; n < 100; ++n) REQUIRE_FALSE(sim.step().failed());
  CHECK(max_abs(sim.position({0})) < 1e-12);
  const Vec3 omega = sim.angular_velocity({0});
  CHECK(std::fabs(omega.x) + std::fabs(omega.y) < 1e-10);
  CHECK(omega.z == doctest::Approx(5.0).epsilon(1e-12));
}

TEST_CASE("a body that turns fast takes steps of a quarter turn at most") {
  Scene scene;
  scene.add_rigid({.mesh = make_box({0.1, 0.2, 0.3}), .mass = 2.0, .angular_velocity = {0, 400, 0}});
  Settings settings = quiet_settings(0.02);
  settings.gravity = {};
  Simulation sim(scene, settings);
  const Vec3 before = spin(sim, 0);
  for (int n = 0; n < 50; ++n) {
    const StepReport& report = sim.step();
    REQUIRE_FALSE(report.failed());
    CHECK(400.0 * report.time_step <= std::numbers::pi / 2 * (1.0 + 1e-12));
  }
  CHECK(norm(spin(sim, 0) - before) < 1e-13 * norm(before));
}

TEST_CASE("a disc that spins fast nutates by a quarter turn in a step at most, with bdf2 by an eighth") {
  // Moments of a flat box: 2 : 1 : 1, it nutates twice as fast as it spins.
  for (const Integrator integrator : {Integrator::ImplicitEuler, Integrator::Bdf2}) {
    Scene scene;
    scene.add_rigid({.mesh = make_box({0.1, 0.1, 0.001}), .mass = 2.0, .angular_velocity = {0, 0, 400}});
    Settings settings = quiet_settings(0.02);
    settings.gravity = {};
    settings.time.integrator = integrator;
    Simulation sim(scene, settings);
    const double angle = std::numbers::pi / (integrator == Integrator::Bdf2 ? 4.0 : 2.0);
    double longest = 0.0;
    for (int n = 0; n < 20; ++n) {
      const StepReport& report = sim.step();
      REQUIRE_FALSE(report.failed());
      longest = std::max(longest, report.time_step);
    }
    CHECK(2.0 * 400.0 * longest == doctest::Approx(angle).epsilon(1e-3));
  }
}

TEST_CASE("internal collisions keep linear momentum to rounding") {
  Settings settings = quiet_settings(0.005);
  settings.gravity = {};
  const auto run = [&](const Scene& scene, int steps) {
    Simulation sim(scene, settings);
    const Vec3 before = linear_momentum(sim), start = sim.velocities({0})[0];
    double exchanged = 0.0, scale = 0.0;
    int64_t contacts = 0;
    for (const double m : sim.model().point_masses()) scale += m;
    for (const RigidMass& m : sim.model().rigid_masses()) scale += m.mass;
    for (int n = 0; n < steps; ++n) {
      REQUIRE_FALSE(sim.step().failed());
      contacts += sim.report().contact_count;
      CHECK(max_abs(linear_momentum(sim) - before) < 1e-11 * scale);  // velocities are of the order of 1 m/s
      exchanged = std::fmax(exchanged, norm(sim.velocities({0})[0] - start));
    }
    CHECK(contacts > 0);
    CHECK(exchanged > 0.3);  // they did collide [m/s]
  };
  SUBCASE("rigid boxes, off centre, with friction") {
    Scene scene;
    scene.set_default_friction(0.3);
    scene.add_rigid(
        {.mesh = make_box({0.1, 0.1, 0.1}), .mass = 1.0, .position = {-0.06, 0, 0}, .velocity = {1, 0.2, 0}});
    scene.add_rigid({.mesh = make_box({0.1, 0.1, 0.1}),
                     .mass = 2.0,
                     .position = {0.06, 0.03, 0.02},
                     .velocity = {-1, 0, 0.1}});
    run(scene, 12);
  }
  SUBCASE("soft boxes") {
    Scene scene;
    scene.set_default_friction(0.3);
    SolidMaterial soft{.density = 1000.0, .youngs_modulus = 1e5, .poissons_ratio = 0.3};
    scene.add_solid({.mesh = make_tet_box({0.1, 0.1, 0.1}, {2, 2, 2}),
                     .material = soft,
                     .position = {-0.06, 0, 0},
                     .velocity = {1, 0, 0}});
    scene.add_solid({.mesh = make_tet_box({0.1, 0.1, 0.1}, {2, 2, 2}),
                     .material = soft,
                     .position = {0.06, 0.02, 0.01},
                     .velocity = {-1, 0, 0}});
    run(scene, 12);
  }
}

TEST_CASE("a hanging strip is stretched by its own weight as the closed form says") {
  // Poisson's ratio 0 makes it uniaxial: strain of a row of cells is the weight below over E t w. Strains of
  // 2e-4 keep the nonlinear terms, of the order of the strain, below the tolerance.
  const int rows = 10;
  const double length = 0.5, width = 0.1, cell = length / rows;
  ShellMaterial material{.density = 0.2,
                         .thickness = 1e-3,
                         .youngs_modulus = 5e6,
                         .poissons_ratio = 0.0,
                         .bending_stiffness = 1e-6};
  ClothDescription cloth{.mesh = make_grid(width, length, 2, rows), .material = material};
  cloth.rotation = exp_rotation({0.5 * std::numbers::pi, 0, 0});  // y of the grid becomes z
  // Slightly stretched at the start: an unstressed sheet has no stiffness across itself, quasistatics needs
  // some.
  for (const Vec3& X : cloth.mesh.vertices)
    cloth.initial_positions.push_back({X.x, 0.5 * length + (X.y - 0.5 * length) * 1.001, X.z});
  Scene scene;
  const BodyId id = scene.add_cloth(cloth);
  std::vector<int32_t> top;
  for (int i = 0; i < 3; ++i) top.push_back(3 * rows + i);
  scene.pin(id, top);
  Settings settings = quiet_settings(1.0);
  settings.time.integrator = Integrator::Quasistatic;
  settings.newton.acceleration_tolerance = 0.0;
  settings.newton.step_tolerance = 0.0;
  settings.newton.residual_tolerance = 1e-10;
  settings.contact.enabled = false;
  Simulation sim(scene, settings);
  const std::vector<Vec3> start = sim.positions(id);
  for (int n = 0; n < 3; ++n) REQUIRE_FALSE(sim.step().failed());
  const std::vector<Vec3> x = sim.positions(id);
  for (const int32_t v : top) CHECK(x[v] == start[v]);
  double expected =
      0.0;  // [m] of elongation, summed from the top; lumping gives a row the mass of half a cell each side
  for (int below = 1; below <= rows; ++below) {
    const double weight = material.density * width * cell * (below - 0.5) * 9.81;
    expected += weight / (material.youngs_modulus * material.thickness * width) * cell;
  }
  double elongation = 0.0;
  for (int i = 0; i < 3; ++i) elongation += (x[top[i]].z - x[i].z - length) / 3.0;
  CHECK(elongation == doctest::Approx(expected).epsilon(5e-3));
}

TEST_CASE("pinned vertices stay, follow their targets exactly, and the sheet between them sags") {
  Scene scene;
  const BodyId id = scene.add_cloth({.mesh = make_grid(0.4, 0.4, 6, 6), .material = materials::cotton()});
  const std::vector<int32_t> corners{0, 6, 42, 48};
  scene.pin(id, corners);
  Settings settings = quiet_settings(0.02);
  settings.contact.enabled = false;
  Simulation sim(scene, settings);
  const std::vector<Vec3> start = sim.positions(id);
  for (int n = 0; n < 50; ++n) REQUIRE_FALSE(sim.step().failed());
  std::vector<Vec3> x = sim.positions(id);
  for (const int32_t v : corners) CHECK(x[v] == start[v]);
  CHECK(x[24].z < -0.02);
  CHECK(x[24].z > -0.2);
  // Symmetric to the diagonals' images: the middle does not drift sideways.
  CHECK(std::fabs(x[24].x) + std::fabs(x[24].y) < 2e-3);
  std::vector<Vec3> targets;
  for (const int32_t v : corners) targets.push_back(start[v] * 0.9 + Vec3{0.01, 0.02, 0.03});
  sim.set_pin_targets(id, targets);
  REQUIRE_FALSE(sim.step().failed());
  x = sim.positions(id);
  for (size_t k = 0; k < corners.size(); ++k) CHECK(x[corners[k]] == targets[k]);
  REQUIRE_FALSE(sim.step().failed());
  x = sim.positions(id);
  for (size_t k = 0; k < corners.size(); ++k) CHECK(x[corners[k]] == targets[k]);
}

TEST_CASE("scripted bodies reach their poses exactly, in contact too, and keep constant velocities") {
  Scene scene;
  const BodyId pusher = scene.add_rigid(
      {.mesh = make_box({0.1, 0.1, 0.1}), .motion = Motion::Scripted, .position = {-0.1, 0, 0}});
  const BodyId pushed =
      scene.add_rigid({.mesh = make_box({0.08, 0.08, 0.08}), .mass = 0.5, .position = {0.0, 0.01, 0.005}});
  Settings settings = quiet_settings(0.01);
  settings.gravity = {};
  Simulation sim(scene, settings);
  for (int n = 1; n <= 10; ++n) {
    const Vec3 position{-0.1 + 0.01 * n, 0.003 * n, 0.0};
    const Mat3 rotation = exp_rotation({0.0, 0.05 * n, 0.02 * n});
    sim.set_pose(pusher, position, rotation);
    REQUIRE_FALSE(sim.step().failed());
    CHECK(sim.position(pusher) == position);
    for (int k = 0; k < 9; ++k) CHECK(std::fabs(sim.rotation(pusher).m[k] - rotation.m[k]) < 1e-15);
    CHECK(intersection_count(sim) == 0);
  }
  CHECK(sim.position(pushed).x > 0.03);  // it was pushed
  const Vec3 rest = sim.position(pusher);
  REQUIRE_FALSE(sim.step().failed());
  CHECK(sim.position(pusher) == rest);  // no new pose: it stays
  sim.set_velocity(pusher, {-1, 0, 0}, {0, 0, 2});
  const Mat3 R = sim.rotation(pusher);
  for (int n = 1; n <= 5; ++n) REQUIRE_FALSE(sim.step().failed());
  CHECK(max_abs(sim.position(pusher) - (rest - Vec3{0.05, 0, 0})) < 1e-14);
  CHECK(max_abs(log_rotation(sim.rotation(pusher) * transpose(R)) - Vec3{0, 0, 0.1}) < 1e-13);
  CHECK(max_abs(sim.angular_velocity(pusher) - Vec3{0, 0, 2}) < 1e-12);
}

TEST_CASE("the state has the same bits for 1, 2 and 5 threads and for both ways to evaluate energies") {
  const Scene scene = contact_scene();
  constexpr int kSteps = 12;
  std::vector<State> states;
  {
    Simulation sim(scene, contact_settings());
    int64_t contacts = 0;
    for (int n = 0; n < kSteps; ++n) {
      REQUIRE_FALSE(sim.step().failed());
      contacts = std::max(contacts, sim.report().contact_count);
      states.push_back(sim.state());
    }
    CHECK(contacts > 10);
    CHECK(intersection_count(sim) == 0);
  }
  const auto compare = [&](const Settings& settings) {
    Simulation sim(scene, settings);
    for (int n = 0; n < kSteps; ++n) {
      sim.step();
      REQUIRE(first_difference(sim.state(), states[n]) == "");
    }
    CHECK(sim.state().hash() == states.back().hash());
  };
  for (const int threads : {1, 2, 5}) {
    CAPTURE(threads);
    Settings settings = contact_settings();
    settings.execution.threads = threads;
    settings.execution.oversubscribe = true;
    compare(settings);
  }
  Settings settings = contact_settings();
  settings.execution.backend = symbolic::Backend::Interpreter;
  compare(settings);
}

TEST_CASE("making a simulation can be stopped between the parts of the work") {
  struct Stop {};
  const Scene scene = contact_scene();
  int parts = 0;
  Simulation whole(scene, contact_settings(), [&] { ++parts; });
  CHECK(parts >= 6);
  for (int last = 1; last <= parts; ++last) {
    int part = 0;
    const auto stop = [&] {
      if (++part == last) throw Stop{};
    };
    CHECK_THROWS_AS(Simulation(scene, contact_settings(), stop), Stop);
  }
  Simulation again(scene, contact_settings());
  again.step();
  whole.step();
  CHECK(first_difference(again.state(), whole.state()) == "");
}

TEST_CASE("assigning a copied state rewinds: the same steps follow") {
  const Scene scene = contact_scene();
  Simulation sim(scene, contact_settings());
  for (int n = 0; n < 6; ++n) REQUIRE_FALSE(sim.step().failed());
  const State middle = sim.state();
  for (int n = 0; n < 6; ++n) REQUIRE_FALSE(sim.step().failed());
  const State end = sim.state();
  CHECK_FALSE(end == middle);
  sim.set_state(middle);
  CHECK(sim.time() == middle.time);
  for (int n = 0; n < 6; ++n) sim.step();
  CHECK(first_difference(sim.state(), end) == "");
}

TEST_CASE("a new simulation goes on from a state with the same bits") {
  const Scene scene = contact_scene();
  Simulation sim(scene, contact_settings());
  for (int n = 0; n < 6; ++n) REQUIRE_FALSE(sim.step().failed());
  Simulation resumed(scene, contact_settings());
  resumed.set_state(sim.state());
  for (int n = 0; n < 6; ++n) {
    sim.step();
    resumed.step();
    CHECK(first_difference(sim.state(), resumed.state()) == "");
  }
}

TEST_CASE("states of another scene are refused") {
  Scene small;
  small.add_rigid({.mesh = make_box({1, 1, 1}), .mass = 1.0});
  Simulation a(small), b(contact_scene(), contact_settings());
  CHECK_THROWS_AS(a.set_state(b.state()), InvalidArgument);
  CHECK_THROWS_AS(b.set_state(a.state()), InvalidArgument);
}

TEST_CASE("initial intersections and contained bodies are refused unless their contact is off") {
  Scene scene;
  const BodyId shell = scene.add_rigid({.mesh = make_box({1, 1, 1}), .motion = Motion::Fixed});
  SUBCASE("contained") {
    const BodyId inner = scene.add_rigid({.mesh = make_box({0.1, 0.1, 0.1}), .mass = 1.0});
    CHECK_THROWS_AS(Simulation{scene}, InitialIntersection);
    scene.disable_contact(shell, inner);
    CHECK_NOTHROW(Simulation{scene});
  }
  SUBCASE("contained cloth") {
    scene.add_cloth({.mesh = make_grid(0.1, 0.1, 2, 2)});
    CHECK_THROWS_AS(Simulation{scene}, InitialIntersection);
  }
  SUBCASE("crossing") {
    const BodyId other =
        scene.add_rigid({.mesh = make_box({0.1, 0.1, 0.1}), .mass = 1.0, .position = {0.5, 0.1, 0.2}});
    CHECK_THROWS_AS(Simulation{scene}, InitialIntersection);
    scene.disable_contact(shell, other);
    CHECK_NOTHROW(Simulation{scene});
  }
  SUBCASE("apart") {
    scene.add_rigid({.mesh = make_box({0.1, 0.1, 0.1}), .mass = 1.0, .position = {0.6, 0.1, 0.2}});
    CHECK_NOTHROW(Simulation{scene});
  }
}

TEST_CASE("bodies may start inside shells: hollow rigid bodies, cloth, walls with room between them") {
  Scene scene;
  scene.add_rigid({.mesh = make_box({0.1, 0.1, 0.1}), .mass = 1.0});
  const auto fits = [&] {
    Settings settings;
    settings.gravity = {0, 0, 0};
    Simulation sim(scene, settings);
    return !sim.step().failed();
  };
  SUBCASE("hollow") {
    scene.add_rigid({.mesh = make_box({1, 1, 1}), .mass = 1.0, .hollow = true});
    CHECK(fits());
  }
  SUBCASE("cloth") {
    scene.add_cloth({.mesh = make_icosphere(0.3, 2)});
    CHECK(fits());
  }
  SUBCASE("wall") {
    TriangleMesh wall = make_box({1, 1, 1});
    const TriangleMesh inner = make_box({0.8, 0.8, 0.8});
    const auto first = static_cast<int32_t>(wall.vertices.size());
    wall.vertices.insert(wall.vertices.end(), inner.vertices.begin(), inner.vertices.end());
    for (const Index3& t : inner.triangles)
      wall.triangles.push_back({first + t[0], first + t[2], first + t[1]});
    scene.add_rigid({.mesh = wall, .density = 1000.0});
    CHECK(fits());
  }
  SUBCASE("a shell inside a solid") {
    scene.add_rigid({.mesh = make_box({0.01, 0.01, 0.01}), .mass = 1.0, .hollow = true});
    CHECK_THROWS_WITH_AS(fits(), doctest::Contains("fills its closed surface"), InitialIntersection);
  }
}

TEST_CASE("hollow bodies have their mass in the surface") {
  Scene scene;
  const BodyId can = scene.add_rigid({.mesh = make_box({1, 1, 1}), .mass = 6.0, .hollow = true});
  // Six faces of 1 kg: (1/12 + 1/12) across, twice; (1/12 + 1/4) of the four others.
  CHECK(scene.rigid_inertia(can).tensor(0, 0) == doctest::Approx(2.0 / 6.0 + 4.0 / 3.0));
  CHECK(scene.warnings().empty());
  CHECK_THROWS_WITH_AS(scene.add_rigid({.mesh = make_box({1, 1, 1}), .density = 1.0, .hollow = true}),
                       doctest::Contains("has no volume"), InvalidArgument);
}
