// The energy balance of a step against closed forms: what falls, slides, is damped or pulled.
#include <doctest/doctest.h>

#include <cmath>

#include <stark/geometry/shapes.h>
#include <stark/sim/simulation.h>
#include <support/joint_scenes.h>
#include <support/simulation_checks.h>

using namespace stark;
using namespace stark::test;

namespace {

Settings tight_settings(double h) {
  Settings settings;
  settings.time.step = h;
  settings.newton.residual_tolerance = 1e-9;
  settings.newton.termination = Termination::All;
  settings.newton.step_tolerance = 1e-9;
  settings.linear.solver = "cholesky";
  return settings;
}

double mass(const Simulation& sim) {
  double total = 0.0;
  for (const double m : sim.model().point_masses()) total += m;
  for (const RigidMass& m : sim.model().rigid_masses()) total += m.mass;
  return total;
}

}  // namespace

TEST_CASE("free fall: implicit Euler loses m (g h)^2 / 2 a step, mass damping takes m a v dx") {
  for (const double rate : {0.0, 0.5}) {
    Scene scene;
    ShellMaterial material{
        .density = 0.2, .youngs_modulus = 5e3, .bending_stiffness = 1e-6, .mass_damping = rate};
    scene.add_cloth({.name = "cloth", .mesh = make_grid(0.2, 0.2, 2, 2), .material = material});
    Simulation sim(scene, tight_settings(0.01));
    Vec3 v_before;
    for (int k = 0; k < 3; ++k) {
      const StepReport& report = sim.step();
      const Vec3 v = sim.state().point_velocity[0];
      const double m = mass(sim);
      CHECK(report.energy.damping == doctest::Approx(m * rate * dot(v, v * 0.01)).epsilon(1e-9));
      CHECK(report.energy.numerical == doctest::Approx(0.5 * m * squared_norm(v - v_before)).epsilon(1e-7));
      CHECK(report.energy.external == 0.0);
      CHECK(report.energy.friction == 0.0);
      CHECK(report.momentum.linear.z == doctest::Approx(m * v.z).epsilon(1e-12));
      v_before = v;
    }
  }
}

TEST_CASE("a sliding block loses its kinetic energy to friction: mu m g over the way") {
  Scene scene;
  scene.set_default_friction(0.3);
  scene.add_rigid(
      {.name = "floor", .mesh = make_box({4, 1, 0.1}), .motion = Motion::Fixed, .position = {0, 0, -0.05}});
  scene.add_rigid({.name = "block",
                   .mesh = make_box({0.1, 0.1, 0.02}),
                   .mass = 0.5,
                   .position = {0, 0, 0.01198},
                   .velocity = {1, 0, 0}});
  Settings settings = tight_settings(0.002);
  settings.contact.friction_updates = 5;
  Simulation sim(scene, settings);
  for (int k = 0; k < 40; ++k) REQUIRE(!sim.step().failed());  // settles on its barrier
  double friction = 0.0, x = sim.state().body_position[1].x;
  for (int k = 0; k < 30; ++k) friction += sim.step().energy.friction;
  x = sim.state().body_position[1].x - x;
  CHECK(friction == doctest::Approx(0.3 * 0.5 * 9.81 * x).epsilon(1e-3));
}

TEST_CASE("contact energy at the start of a step closes the balance with the one before") {
  Scene scene;
  scene.add_rigid(
      {.name = "floor", .mesh = make_box({4, 1, 0.1}), .motion = Motion::Fixed, .position = {0, 0, -0.05}});
  scene.add_cloth({.name = "cloth", .mesh = make_grid(0.2, 0.2, 3, 3), .position = {0, 0, 0.0025}});
  Simulation sim(scene, tight_settings(0.005));
  StepReport before = sim.step();
  CHECK(before.contact_energy_at_start == 0.0);  // not in touch yet
  CHECK(before.bristle_energy_at_start == 0.0);
  int touching = 0;
  for (int k = 0; k < 30; ++k) {
    const StepReport report = sim.step();
    REQUIRE(!report.failed());
    const EnergyLedger &a = before.energy, &b = report.energy;
    const double start = a.kinetic + a.elastic + a.gravity + report.contact_energy_at_start;
    const double turned_over = b.external + b.actuation - b.damping - b.friction - b.numerical;
    CHECK(std::fabs(b.stored() - start - turned_over) < 1e-12);
    CHECK((report.contact_energy_at_start > 0.0) == (a.contact > 0.0));
    touching += a.contact > 0.0 ? 1 : 0;
    before = report;
  }
  CHECK(touching > 10);
}

TEST_CASE("pulling a strip: the work of the pins is what the strip stores and its damping takes") {
  for (const double damping : {0.0, 5.0}) {
    Scene scene;
    ShellMaterial material{.density = 0.2, .youngs_modulus = 5e3, .bending_stiffness = 1e-6};
    material.strain_damping = damping;
    const TriangleMesh mesh = make_grid(0.4, 0.1, 8, 2);
    std::vector<int32_t> pins;
    for (int32_t v = 0; v < static_cast<int32_t>(mesh.vertices.size()); ++v)
      if (std::fabs(std::fabs(mesh.vertices[v].x) - 0.2) < 1e-9) pins.push_back(v);
    const BodyId cloth = scene.add_cloth({.name = "strip", .mesh = mesh, .material = material});
    scene.pin(cloth, pins);
    Settings settings = tight_settings(0.01);
    settings.time.integrator = Integrator::Quasistatic;
    settings.gravity = {};
    settings.contact.enabled = false;
    Simulation sim(scene, settings);
    double external = 0.0, numerical = 0.0, elastic = 0.0;
    for (int k = 1; k <= 50; ++k) {
      std::vector<Vec3> targets;
      for (const int32_t pin : pins) targets.push_back(mesh.vertices[pin] * (1.0 + 0.002 * k));
      sim.set_pin_targets(cloth, targets);
      const StepReport& report = sim.step();
      REQUIRE(!report.failed());
      external += report.energy.external;
      numerical += report.energy.numerical;
      elastic = report.energy.elastic;
      CHECK(std::fabs(report.energy.damping) < 1e-15);  // a quasistatic step has no rates
    }
    CHECK(elastic > 1e-4);
    // The work is taken with the forces at the end of each step: 1/50 too much for a force that grows
    // linearly.
    CHECK(external / elastic == doctest::Approx(1.02).epsilon(5e-3));
    CHECK(numerical == doctest::Approx(external - elastic).epsilon(1e-9));
  }
}

TEST_CASE("material damping is a loss, and a vibration ends with all losses accounted for") {
  Scene scene;
  ShellMaterial material{.density = 0.2, .youngs_modulus = 5e3, .bending_stiffness = 1e-6};
  material.strain_damping = 1.0;
  TriangleMesh mesh = make_grid(0.2, 0.2, 2, 2);
  std::vector<Vec3> stretched = mesh.vertices;
  for (Vec3& p : stretched) p.x *= 1.1;
  scene.add_cloth({.name = "cloth", .mesh = mesh, .material = material, .initial_positions = stretched});
  Settings settings = tight_settings(0.0005);
  settings.gravity = {};
  Simulation sim(scene, settings);
  double lost = 0.0, numerical = 0.0, first = 0.0;
  for (int k = 0; k < 200; ++k) {
    const StepReport& report = sim.step();
    REQUIRE(!report.failed());
    CHECK(report.energy.damping >= -1e-15);
    CHECK(report.energy.numerical >= -1e-12);
    if (k == 0) first = report.energy.stored() + report.energy.damping + report.energy.numerical;
    lost += report.energy.damping;
    numerical += report.energy.numerical;
  }
  CHECK(first == doctest::Approx(sim.report().energy.stored() + lost + numerical).epsilon(1e-9));
  CHECK(lost > 0.3 * first);
}

TEST_CASE("angular momentum of the report is that of the bodies") {
  Scene scene;
  scene.add_rigid({.name = "block",
                   .mesh = make_box({0.1, 0.06, 0.02}),
                   .mass = 0.3,
                   .position = {1, 2, 3},
                   .velocity = {0.5, 0, 0},
                   .angular_velocity = {1, 2, 3}});
  Settings settings = tight_settings(1e-4);
  settings.gravity = {};
  Simulation sim(scene, settings);
  const StepReport& report = sim.step();
  const Vec3 expected =
      cross(sim.state().body_position[0], sim.state().body_velocity[0] * 0.3) + spin(sim, 0);
  CHECK(norm(report.momentum.angular - expected) < 1e-15);
  CHECK(report.momentum.linear.x == doctest::Approx(0.15).epsilon(1e-9));
}

TEST_CASE("a motor's work is the kinetic energy of what it drives, less what the integration loses") {
  const double moment = 0.01;
  Machine m = machine("hinge", wheel(moment));
  add(m.scene, "effort", m.joint, {{"target", 0.2}});
  Settings settings = tight_settings(1e-3);
  settings.gravity = {};
  Simulation sim(m.scene, settings);
  double work = 0.0, numerical = 0.0;
  for (int k = 0; k < 100; ++k) {
    REQUIRE(!sim.step().failed());
    work += sim.report().energy.actuation;
    numerical += sim.report().energy.numerical;
  }
  const double rate = 0.2 * 0.1 / moment;
  CHECK(sim.report().energy.kinetic == doctest::Approx(0.5 * moment * rate * rate).epsilon(5e-3));
  CHECK(work == doctest::Approx(sim.report().energy.kinetic + numerical).epsilon(1e-9));
  CHECK(numerical / work == doctest::Approx(0.01).epsilon(0.1));  // 1 / steps, for a constant acceleration
}
