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
  settings.linear.solver = "cholesky";
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

TEST_CASE("free fall is exact with BDF2 from its second step on, with steps of any length") {
  Settings settings = bdf2_settings(0.01);
  Scene scene;
  scene.add_rigid({.name = "block", .mesh = make_box({0.1, 0.06, 0.02}), .mass = 0.3, .velocity = {1, 0, 2}});
  Simulation sim(scene, settings);
  double t = 0.0, off = 0.0;
  for (const double h : {0.01, 0.01, 0.005, 0.01, 0.003, 0.006}) {
    REQUIRE(!sim.step(h).failed());
    t += h;
    // The first step is one of implicit Euler, which falls too far by g h^2/2.
    if (off == 0.0) off = -9.81 * h * h / 2.0;
    CHECK(sim.state().body_position[0].z ==
          doctest::Approx(2.0 * t - 9.81 * t * t / 2.0 + off).epsilon(1e-12));
    CHECK(sim.state().body_velocity[0].z == doctest::Approx(2.0 - 9.81 * t).epsilon(1e-12));
  }
  // A step that grows too fast is one of implicit Euler again.
  REQUIRE(!sim.step(0.002).failed());
  const StepReport& report = sim.step(0.01);
  REQUIRE(!report.failed());
  CHECK(report.integrator == Integrator::ImplicitEuler);
}

TEST_CASE("an impact has no history: what falls on the floor is not thrown back by it") {
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
  bool met = false;
  for (int k = 0; k < 60; ++k) {
    REQUIRE(!sim.step().failed());
    CHECK(sim.report().integrator == (k == 0 ? Integrator::ImplicitEuler : Integrator::Bdf2));
    const double z = sim.state().body_position[1].z;
    met = met || sim.report().contact_count > 0;
    if (met) highest_after_impact = std::max(highest_after_impact, z);
    lowest = std::min(lowest, z);
  }
  CHECK(met);
  CHECK(lowest > 0.01);
  // What contact stored on the way in, the integrator does not all take: less than a tenth of the 51 mm that
  // 1 m/s is worth is left. Off a history, it is a quarter.
  CHECK(highest_after_impact < 0.01 + 5.1e-3);
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
