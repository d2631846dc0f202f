// Time steps under stress: failing and halved steps, bullets against thin things, small and light bodies.
#include <doctest/doctest.h>

#include <stark/base/rotation.h>
#include <stark/geometry/shapes.h>
#include <stark/sim/simulation.h>
#include <support/simulation_checks.h>

using namespace stark;
using namespace stark::test;

namespace {

/// Vertices of a grid or box mesh on the rim |x| or |y| = half.
std::vector<int32_t> rim(const std::vector<Vec3>& vertices, double half) {
  std::vector<int32_t> result;
  for (size_t i = 0; i < vertices.size(); ++i)
    if (std::fabs(vertices[i].x) > half - 1e-9 || std::fabs(vertices[i].y) > half - 1e-9)
      result.push_back(static_cast<int32_t>(i));
  return result;
}

/// A body dropped onto a pinned sheet, in contact within the first step.
Scene drop_scene() {
  Scene scene;
  const TriangleMesh grid = make_grid(0.2, 0.2, 6, 6);
  const BodyId cloth = scene.add_cloth({.mesh = grid, .material = materials::cotton()});
  scene.pin(cloth, rim(grid.vertices, 0.1));
  scene.add_rigid({.mesh = make_box({0.03, 0.03, 0.03}),
                   .mass = 0.1,
                   .position = {0.01, 0.0, 0.02},
                   .velocity = {0, 0, -3}});
  return scene;
}

struct Shot {
  const char* name;
  TriangleMesh mesh;
  double mass;      ///< [kg]
  double distance;  ///< [m] of its centre from the target
  double speed;     ///< [m/s]
};

/// Shoots along -z at the sheet of `target` in the plane z = 0 and checks, step by step, that the bullet
/// stays on its side: by the solid angle of the pinned sheet and by exact intersection tests.
void check_no_passage(Scene scene, BodyId target, const std::vector<Index3>& sheet, const Shot& shot,
                      double h) {
  CAPTURE(shot.name);
  CAPTURE(h);
  const BodyId bullet = scene.add_rigid({.mesh = shot.mesh,
                                         .mass = shot.mass,
                                         .position = {0.003, -0.002, shot.distance},
                                         .velocity = {0, 0, -shot.speed}});
  Settings settings;
  settings.time.step = h;
  settings.contact.distance = 5e-4;
  Simulation sim(scene, settings);
  REQUIRE(solid_angle(sim.position(bullet), sim.positions(target), sheet) > 0.0);
  bool met = false;
  for (int n = 0; n < 5; ++n) {
    const StepReport& report = sim.step();
    INFO(report.brief());
    REQUIRE_FALSE(report.failed());
    met = met || report.contact_count > 0 || report.rejected_steps > 0;
    CHECK(intersection_count(sim) == 0);
    const std::vector<Vec3> x = sim.positions(target);
    for (const Vec3& v : sim.positions(bullet)) REQUIRE(solid_angle(v, x, sheet) > 0.0);
  }
  // Without the target it would be far below by now: it was stopped, not missed.
  CHECK(met);
  CHECK(sim.linear_velocity(bullet).z > -0.9 * shot.speed);
}

std::vector<Shot> shots() {
  return {{"ball of 5 mm at 100 m/s", make_icosphere(0.0025, 1), 5e-4, 0.02, 100.0},
          {"plate of 1 mm at 200 m/s", make_box({0.03, 0.03, 0.001}), 5e-3, 0.02, 200.0},
          {"plate edge on at 200 m/s", make_box({0.03, 0.001, 0.03}), 5e-3, 0.03, 200.0}};
}

}  // namespace

TEST_CASE("solid angles tell the sides of a sheet apart") {
  const TriangleMesh grid = make_grid(0.2, 0.2, 6, 6);
  CHECK(solid_angle({0, 0, 1e-4}, grid.vertices, grid.triangles) == doctest::Approx(6.28).epsilon(0.01));
  CHECK(solid_angle({0, 0, -1e-4}, grid.vertices, grid.triangles) == doctest::Approx(-6.28).epsilon(0.01));
  CHECK(solid_angle({0.3, 0.5, 0.2}, grid.vertices, grid.triangles) > 0.0);
}

TEST_CASE("a step that fails leaves the state as it was, bit for bit, and says why") {
  Settings settings;
  settings.time.step = 0.01;
  settings.time.min_step = 0.006;
  settings.newton.max_iterations = 1;
  settings.newton.acceleration_tolerance = 1e-9;
  Simulation sim(drop_scene(), settings);
  const State before = sim.state();
  const StepReport& report = sim.step();
  CHECK(report.status == StepStatus::Failed);
  CHECK(report.failed());
  CHECK(report.rejected_steps == 1);
  CHECK(report.solve.status == SolveStatus::MaxIterations);
  CHECK(report.message.find("newton.max_iterations") != std::string::npos);
  CHECK(report.message.find("time.min_step") != std::string::npos);
  CHECK(first_difference(sim.state(), before) == "");
  CHECK(sim.time() == 0.0);
}

TEST_CASE("a step that does not converge is halved, and the step size grows back") {
  Settings settings;
  settings.time.step = 0.016;
  settings.newton.max_iterations = 8;
  Simulation sim(drop_scene(), settings);
  int retried = 0;
  double time = 0.0;
  for (int n = 0; n < 12; ++n) {
    const StepReport& report = sim.step();
    REQUIRE_FALSE(report.failed());
    time += report.time_step;
    CHECK(sim.time() == doctest::Approx(time).epsilon(1e-14));
    CHECK(report.step == n + 1);
    if (report.status == StepStatus::Retried) {
      ++retried;
      CHECK(report.rejected_steps > 0);
      CHECK_FALSE(report.message.empty());
      CHECK(report.time_step < settings.time.step);
    } else {
      CHECK(report.rejected_steps == 0);
    }
    CHECK(sim.state().time_step <= settings.time.step);
    CHECK(sim.state().time_step >= report.time_step);
  }
  CHECK(retried > 0);
}

TEST_CASE("a step that is out of time fails at once and leaves the state as it was") {
  Settings settings;
  settings.newton.max_seconds = 1e-9;
  Simulation sim(drop_scene(), settings);
  const State before = sim.state();
  const StepReport& report = sim.step();
  CHECK(report.status == StepStatus::Failed);
  CHECK(report.rejected_steps == 1);
  CHECK(report.solve.status == SolveStatus::TimeBudget);
  CHECK(report.diagnosis.cause == FailureCause::TimeBudget);
  CHECK(report.message.find("newton.max_seconds") != std::string::npos);
  CHECK(report.message.find("time.min_step") == std::string::npos);
  CHECK(first_difference(sim.state(), before) == "");
}

TEST_CASE("a step that leads around an obstacle is taken in pieces, however short") {
  // A ball that is a step away from a wall and fast enough to be behind it, in steps of 1/32 of the full one.
  Scene scene;
  scene.add_rigid({.mesh = make_box({0.01, 0.4, 0.4}), .motion = Motion::Fixed});
  const BodyId ball = scene.add_rigid({.mesh = make_icosphere(0.05, 1),
                                       .mass = 1.0,
                                       .position = {-0.1, 0.19, 0.0},
                                       .velocity = {300.0, 0.0, 0.0}});
  Settings settings;
  settings.time.step = 1.0 / 60.0;
  Simulation sim(scene, settings);
  int retried = 0;
  for (int n = 0; n < 4; ++n) {
    const StepReport& report = sim.step(settings.time.step / 32.0);
    REQUIRE_FALSE(report.failed());
    retried += report.status == StepStatus::Retried;
    CHECK(sim.position(ball).x < 0.0);
  }
  CHECK(retried > 0);
}

TEST_CASE("a step that has a way around an obstacle only fails and names both") {
  Scene scene;
  scene.add_rigid({.name = "plate", .mesh = make_box({0.01, 0.01, 0.001}), .mass = 1e-3});
  scene.add_rigid({.name = "cube",
                   .mesh = make_box({0.002, 0.002, 0.002}),
                   .mass = 8e-6,
                   .position = {0, 0, 0.004},
                   .rotation = exp_rotation({0.3, 0.5, 0.7}),
                   .velocity = {0, 0, -40.0}});
  Settings settings;
  settings.gravity = {};
  settings.time.min_step = settings.time.step = 1.0 / 60.0;
  Simulation sim(scene, settings);
  const State before = sim.state();
  const StepReport& report = sim.step();
  CHECK(report.status == StepStatus::Failed);
  CHECK(report.diagnosis.cause == FailureCause::Detour);
  CHECK(report.message.find("time.min_step") != std::string::npos);
  REQUIRE(report.diagnosis.evidence.in_the_way);
  CHECK(report.diagnosis.bodies == std::vector<std::string>{"rigid body 'cube'", "rigid body 'plate'"});
  CHECK(first_difference(sim.state(), before) == "");
}

TEST_CASE("a small fast body does not pass a free plate") {
  for (const double speed : {2.0, 7.7, 40.0, 300.0}) {
    CAPTURE(speed);
    Scene scene;
    const BodyId plate = scene.add_rigid({.mesh = make_box({0.01, 0.01, 0.001}), .mass = 1e-3});
    const BodyId cube = scene.add_rigid({.mesh = make_box({0.002, 0.002, 0.002}),
                                         .mass = 8e-6,
                                         .position = {0, 0, 0.004},
                                         .rotation = exp_rotation({0.3, 0.5, 0.7}),
                                         .velocity = {0, 0, -speed}});
    Settings settings;
    settings.gravity = {};
    Simulation sim(scene, settings);
    int64_t contacts = 0;
    for (int n = 0; n < 30 && contacts == 0; ++n) {
      const StepReport& report = sim.step();
      REQUIRE_FALSE(report.failed());
      contacts += report.contact_count;
      CHECK(sim.position(cube).z > sim.position(plate).z);
    }
    CHECK(contacts > 0);
  }
}

TEST_CASE("interrupted steps leave the state as it was") {
  Simulation sim(drop_scene());
  const State before = sim.state();
  sim.set_interrupt([] { return true; });
  CHECK(sim.step().status == StepStatus::Interrupted);
  CHECK(first_difference(sim.state(), before) == "");
  sim.set_interrupt([] { return false; });
  CHECK(sim.step().status == StepStatus::Accepted);
}

TEST_CASE("a step cut short by the caller does not shorten the next") {
  Scene scene;
  scene.add_rigid({.mesh = make_box({1, 1, 1}), .mass = 1.0});
  Settings settings;
  settings.time.step = 0.01;
  Simulation sim(scene, settings);
  CHECK(sim.step(0.003).time_step == 0.003);
  CHECK(sim.step().time_step == 0.01);
  CHECK(sim.time() == doctest::Approx(0.013).epsilon(1e-14));
}

TEST_CASE("a step cut short does not throw off what rests on something") {
  // Barriers scaled with the step at hand would push with (0.01 s / 10 us)^2 times the force.
  for (const double h : {3e-3, 1e-4, 1e-5}) {
    CAPTURE(h);
    Scene scene;
    scene.add_rigid({.mesh = make_box({1, 1, 0.1}), .motion = Motion::Fixed, .position = {0, 0, -0.05}});
    const BodyId box =
        scene.add_rigid({.mesh = make_box({0.03, 0.03, 0.03}), .mass = 0.1, .position = {0.01, 0, 0.0168}});
    Settings settings;
    settings.time.step = 0.01;
    Simulation sim(scene, settings);
    for (int n = 0; n < 40; ++n) REQUIRE_FALSE(sim.step().failed());
    REQUIRE(sim.report().contact_count > 0);
    const double before = sim.position(box).z;
    REQUIRE_FALSE(sim.step(h).failed());
    CHECK(norm(sim.linear_velocity(box)) < 1e-6);  // at rest within the tolerances of the solver
    CHECK(std::fabs(sim.position(box).z - before) < 1e-9);
  }
}

TEST_CASE("bullets do not pass a pinned cloth") {
  for (const double h : {1.0 / 30.0, 0.01})
    for (const Shot& shot : shots()) {
      Scene scene;
      const TriangleMesh grid = make_grid(0.2, 0.2, 8, 8);
      const BodyId cloth = scene.add_cloth({.mesh = grid, .material = materials::cotton()});
      scene.pin(cloth, rim(grid.vertices, 0.1));
      check_no_passage(scene, cloth, grid.triangles, shot, h);
    }
}

TEST_CASE("bullets do not pass a thin solid") {
  for (const double h : {1.0 / 30.0, 0.01})
    for (const Shot& shot : shots()) {
      Scene scene;
      const TetMesh mesh = make_tet_box({0.2, 0.2, 0.004}, {6, 6, 1});
      const BodyId solid = scene.add_solid(
          {.mesh = mesh, .material = {.density = 1000.0, .youngs_modulus = 1e6, .poissons_ratio = 0.4}});
      scene.pin(solid, rim(mesh.vertices, 0.1));
      // The sheet to tell the sides apart: the lower face.
      std::vector<Index3> lower;
      const Simulation probe(scene);
      for (const Index3& t : probe.triangles(solid))
        if (mesh.vertices[t[0]].z < -0.0019 && mesh.vertices[t[1]].z < -0.0019 &&
            mesh.vertices[t[2]].z < -0.0019)
          lower.push_back({t[0], t[2], t[1]});  // normals up
      REQUIRE(lower.size() == 72);
      check_no_passage(scene, solid, lower, shot, h);
    }
}

TEST_CASE("a bullet does not pass a fixed plate of 0.1 mm at 10 km/s") {
  Scene scene;
  const BodyId plate = scene.add_rigid({.mesh = make_box({0.2, 0.2, 1e-4}), .motion = Motion::Fixed});
  const BodyId ball = scene.add_rigid({.mesh = make_icosphere(0.0025, 1),
                                       .mass = 5e-4,
                                       .position = {0.01, 0.02, 1.0},
                                       .velocity = {0, 0, -1e4}});
  Settings settings;
  settings.time.step = 1.0 / 30.0;
  settings.contact.distance = 5e-4;
  Simulation sim(scene, settings);
  for (int n = 0; n < 4; ++n) {
    REQUIRE_FALSE(sim.step().failed());
    CHECK(sim.position(ball).z > 0.0);
    CHECK(intersection_count(sim) == 0);
  }
  CHECK(sim.position(ball).z < 1.0);
  CHECK(sim.position(plate) == Vec3{});
}

TEST_CASE("small and light bodies fall as heavy ones do, with default tolerances") {
  const double h = 1e-3;
  Settings settings;
  settings.time.step = h;
  Scene scene;
  const BodyId patch =
      scene.add_cloth({.mesh = make_grid(0.03, 0.03, 6, 6), .material = materials::cotton()});
  ShellMaterial undamped = materials::cotton();
  undamped.mass_damping = 0.0;
  const BodyId free_patch =
      scene.add_cloth({.mesh = make_grid(0.03, 0.03, 6, 6), .material = undamped, .position = {0.1, 0, 0}});
  const BodyId box =
      scene.add_rigid({.mesh = make_box({0.005, 0.005, 0.005}), .mass = 1e-4, .position = {0.2, 0, 0}});
  const BodyId anvil =
      scene.add_rigid({.mesh = make_box({0.5, 0.5, 0.5}), .mass = 1e3, .position = {1, 0, 0}});
  Simulation sim(scene, settings);
  const double g = settings.gravity.z, a = materials::cotton().mass_damping;
  double damped_z = 0.0, damped_v = 0.0;
  for (int n = 1; n <= 100; ++n) {
    REQUIRE(sim.step().status == StepStatus::Accepted);
    const double z = 0.5 * n * (n + 1) * h * h * g;
    damped_v = (damped_v + h * g) / (1.0 + a * h);
    damped_z += h * damped_v;
    CHECK(sim.position(box).z == doctest::Approx(z).epsilon(1e-9));
    CHECK(sim.position(anvil).z == doctest::Approx(z).epsilon(1e-9));
    for (const Vec3& x : sim.positions(free_patch)) CHECK(x.z == doctest::Approx(z).epsilon(1e-9));
    for (const Vec3& x : sim.positions(patch)) CHECK(x.z == doctest::Approx(damped_z).epsilon(1e-9));
  }
}

TEST_CASE("boxes that fly at each other do not change places within a step") {
  for (const double speed : {6.0, 10.0, 20.0}) {
    CAPTURE(speed);
    Scene scene;
    const auto add = [&](double side, double y) {
      return scene.add_rigid({.mesh = make_box({0.05, 0.05, 0.05}),
                              .mass = 1.0,
                              .position = {0.05 * side, y, 0},
                              .velocity = {-side * speed, 0, 0}});
    };
    const BodyId a = add(-1.0, 0.0), b = add(1.0, 0.01);
    Settings settings;
    settings.time.step = 1.0 / 60.0;
    settings.gravity = {0, 0, 0};
    Simulation sim(scene, settings);
    int rejected = 0;
    for (int n = 0; n < 2; ++n) {
      const StepReport& report = sim.step();
      REQUIRE_FALSE(report.failed());
      rejected += report.rejected_steps;
      CHECK(sim.position(a).x < sim.position(b).x);
    }
    CHECK(rejected > 0);
    // Momentum along their way: they have met.
    CHECK(sim.linear_velocity(a).x < 0.6 * speed);
  }
}
