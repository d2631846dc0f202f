// BDF2: order, start, variable steps, impacts, resuming; implicit Euler keeps no history.
#include <doctest/doctest.h>

#include <cmath>

#include <stark/geometry/shapes.h>
#include <stark/sim/simulation.h>
#include <support/joint_scenes.h>
#include <support/simulation_checks.h>

using namespace stark;
using namespace stark::test;

namespace {

Settings bdf2_settings(double h) {
  Settings settings;
  settings.time.step = h;
  settings.time.integrator = Integrator::Bdf2;
  settings.newton.residual_tolerance = 1e-12;
  settings.newton.acceleration_tolerance = 0.0;
  settings.newton.step_tolerance = 1e-12;
  settings.linear.solver = LinearSolverKind::Cholesky;
  return settings;
}

/// On a ball joint beside its centre of mass: free motion alone would be exact.
Scene tumbling_block() {
  Scene scene;
  const Vec3 spin{0.5, 4.0, 1.0}, centre{0.04, 0.0, 0.01};
  const BodyId block = scene.add_rigid({.name = "block",
                                        .mesh = make_box({0.1, 0.06, 0.02}),
                                        .mass = 0.3,
                                        .position = centre,
                                        .velocity = cross(spin, centre),
                                        .angular_velocity = spin});
  scene.add_joint(
      {.definition = find_joint("ball"), .a = world_frame({}), .b = body_frame(block, centre * -1.0)});
  return scene;
}

/// Angle by which the block of a simulation with steps h has turned away from that of `other. after 0.2 s.
double turn_after(double h, const Settings& base, const Mat3& exact, Mat3* out = nullptr) {
  Settings settings = base;
  settings.time.step = h;
  Simulation sim(tumbling_block(), settings);
  while (sim.time() < 0.2 - 1e-9) REQUIRE(!sim.step().failed());
  const Mat3 R = sim.state().body_rotation[0];
  if (out) *out = R;
  const Mat3 D = R - exact;
  double sum = 0.0;
  for (const double v : D.m) sum += v * v;
  return std::sqrt(sum / 2.0);
}

}  // namespace

TEST_CASE("a tumbling block converges with order 2, with implicit Euler with order 1") {
  for (const auto& [integrator, order] :
       {std::pair{Integrator::Bdf2, 2.0}, {Integrator::ImplicitEuler, 1.0}}) {
    Settings settings = bdf2_settings(0.01);
    settings.time.integrator = integrator;
    Mat3 exact;  // by Richardson's extrapolation of the two finest
    Mat3 fine, finer;
    turn_after(0.2 / 800, settings, exact, &fine);
    turn_after(0.2 / 1600, settings, exact, &finer);
    exact = finer + (finer - fine) * (1.0 / (std::pow(2.0, order) - 1.0));
    const double coarse = turn_after(0.2 / 100, settings, exact),
                 half = turn_after(0.2 / 200, settings, exact);
    CHECK(std::log2(coarse / half) == doctest::Approx(order).epsilon(0.1));
  }
}

TEST_CASE("BDF2 falls exactly as its recursion, started by implicit Euler, with steps of any length") {
  Settings settings = bdf2_settings(0.01);
  Scene scene;
  scene.add_rigid({.name = "block", .mesh = make_box({0.1, 0.06, 0.02}), .mass = 0.3, .velocity = {1, 0, 2}});
  Simulation sim(scene, settings);
  double z = 0.0, v = 2.0, z_before = 0.0, v_before = 0.0, h_before = 0.0;
  for (const double h : {0.01, 0.01, 0.005, 0.01, 0.003, 0.01}) {
    // 0.003 to 0.01 grows too fast: implicit Euler again
    const bool start = h_before == 0.0 || h > 2.0 * h_before;
    const double w = start ? 0.0 : h / h_before, c = w * w / (1 + 2 * w);
    const double s = start ? h : h * (1 + w) / (1 + 2 * w);
    const double from = z + c * (z - z_before), v_from = v + c * (v - v_before);
    const double v_new = v_from - 9.81 * s, z_new = from + s * v_new;
    z_before = z;
    v_before = v;
    z = z_new;
    v = v_new;
    h_before = h;
    REQUIRE(!sim.step(h).failed());
    CHECK(sim.state().body_position[0].z == doctest::Approx(z).epsilon(1e-12));
    CHECK(sim.state().body_velocity[0].z == doctest::Approx(v).epsilon(1e-12));
  }
}

TEST_CASE("an impact starts BDF2 again: what falls on the floor does not bounce off the history") {
  Scene scene;
  scene.add_rigid(
      {.name = "floor", .mesh = make_box({1, 1, 0.1}), .motion = Motion::Fixed, .position = {0, 0, -0.05}});
  scene.add_rigid({.name = "block",
                   .mesh = make_box({0.1, 0.06, 0.02}),
                   .mass = 0.3,
                   .position = {0, 0, 0.03},
                   .velocity = {0, 0, -1}});
  Settings settings = bdf2_settings(0.005);
  settings.newton = {};
  Simulation sim(scene, settings);
  double highest_after_impact = 0.0, lowest = 1.0;
  bool restarted = false;
  for (int k = 0; k < 60; ++k) {
    REQUIRE(!sim.step().failed());
    const double z = sim.state().body_position[1].z;
    restarted = restarted || (k > 0 && sim.state().previous_time_step == 0.0);
    if (restarted) highest_after_impact = std::max(highest_after_impact, z);
    lowest = std::min(lowest, z);
  }
  CHECK(restarted);
  CHECK(sim.state().previous_time_step > 0.0);  // at rest the history is back
  CHECK(lowest > 0.01);
  // Within contact distance and a millimetre: what contact stored on the way in, the integrator does not all
  // take. Off a history, a quarter of the 51 mm that 1 m/s is worth.
  CHECK(highest_after_impact < 0.01 + 3e-3);
  CHECK(std::fabs(sim.state().body_velocity[1].z) < 1e-4);
}

TEST_CASE("the history belongs to the state: a rewound simulation repeats itself in every bit") {
  const Settings settings = bdf2_settings(0.01);
  Simulation sim(tumbling_block(), settings);
  for (int k = 0; k < 5; ++k) sim.step();
  const State middle = sim.state();
  for (int k = 0; k < 5; ++k) sim.step();
  const uint64_t end = sim.state().hash();
  Simulation other(tumbling_block(), settings);
  other.set_state(middle);
  for (int k = 0; k < 5; ++k) other.step();
  CHECK(other.state().hash() == end);
}

TEST_CASE("implicit Euler keeps no history") {
  Settings settings = bdf2_settings(0.01);
  settings.time.integrator = Integrator::ImplicitEuler;
  Simulation sim(tumbling_block(), settings);
  sim.step();
  CHECK(sim.state().previous_body_position.empty());
  CHECK(sim.state().previous_time_step == 0.0);
}
