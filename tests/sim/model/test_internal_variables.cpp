// Internal variables of energies between the state and the batches: initial values, updates of accepted
// steps, rewinding, what the ledger has of them.
#include <doctest/doctest.h>

#include <algorithm>

#include <stark/stark.h>

using namespace stark;
using doctest::Approx;

namespace {

/// A spring to the origin in a row with a dashpot whose extension is remembered; counts its steps.
PotentialDefinition maxwell() {
  PotentialDefinition definition =
      define_potential("maxwell", 1, "spring and dashpot", [](PotentialBuilder& b) {
        const auto flow = b.internal("flow", {0.0}, "m", "extension of the dashpot")[0];
        const auto count = b.internal("count", {2.0}, "1", "accepted steps")[0];
        const auto ratio = b.time_step() / b.parameter("relaxation", "s", "relaxation time");
        const auto trial = b.x(0)[0] - flow;
        b.update("flow", {flow + ratio / (1.0 + ratio) * trial});
        b.update("count", {count + 1.0});
        return 0.5 * 100.0 / (1.0 + ratio) * trial * trial;
      });
  definition.translation_invariant = false;
  return definition;
}

Scene scene_of_maxwell() {
  Scene scene;
  const BodyId box = scene.add_rigid({.mesh = make_box({0.1, 0.1, 0.1}), .mass = 1.0, .position = {1, 0, 0}});
  scene.add_energy({.potential = maxwell(),
                    .points = {body_points(box, {{0, 0, 0}})},
                    .values = {{"relaxation", {{0.1}}}}});
  return scene;
}

Settings settings_of() {
  Settings settings;
  settings.time.step = 0.01;
  settings.gravity = {};
  settings.contact.enabled = false;
  settings.newton.step_tolerance = 1e-12;
  return settings;
}

}  // namespace

TEST_CASE("internal variables follow their formula, and the ledger closes") {
  Simulation simulation(scene_of_maxwell(), settings_of());
  CHECK(simulation.state().internal_variable == std::vector<double>{0.0, 2.0});
  double x = 1.0, v = 0.0, flow = 0.0;
  const double stiffness = 100.0 / 1.1;  // ratio h / relaxation = 0.1
  for (int n = 0; n < 20; ++n) {
    REQUIRE_FALSE(simulation.step().failed());
    const double held = 50.0 * (x - flow) * (x - flow) * (1.0 - 1.0 / 1.21);  // what rest would have cost
    v = (v - 0.01 * stiffness * (x - flow)) / (1.0 + 1e-4 * stiffness);
    x += 0.01 * v;
    const double slip = 0.1 / 1.1 * (x - flow);
    flow += slip;
    const std::vector<double>& now = simulation.state().internal_variable;
    REQUIRE(now.size() == 2);
    CHECK(now[0] == Approx(flow).epsilon(1e-9));
    CHECK(now[1] == 3.0 + n);
    // The force of the dashpot, 100 times 0.1 s times its rate, on its way.
    const double dissipated = std::max(100.0 * 0.1 / 0.01 * slip * slip, held);
    CHECK(simulation.report().energy.damping == Approx(dissipated).epsilon(1e-7));
    CHECK(simulation.report().energy.elastic == Approx(50.0 * (x - flow) * (x - flow)).epsilon(1e-7));
  }
}

TEST_CASE("a rewound simulation takes the same steps, bit for bit") {
  Simulation simulation(scene_of_maxwell(), settings_of());
  for (int n = 0; n < 5; ++n) simulation.step();
  const State middle = simulation.state();
  for (int n = 0; n < 5; ++n) simulation.step();
  const State end = simulation.state();
  CHECK(end.hash() != middle.hash());
  simulation.set_state(middle);
  for (int n = 0; n < 5; ++n) simulation.step();
  CHECK(simulation.state() == end);
  simulation.reset();
  CHECK(simulation.state().internal_variable == std::vector<double>{0.0, 2.0});
}

TEST_CASE("updates of what is not declared, or twice, are refused") {
  PotentialBuilder b(1);
  b.internal("flow", {0.0, 0.0}, "m", "");
  CHECK_THROWS_WITH_AS(b.update("flaw", {0.0}), doctest::Contains("must be an internal variable"),
                       InvalidArgument);
  CHECK_THROWS_WITH_AS(b.update("flow", {0.0}), doctest::Contains("got 1 numbers, must be 2"),
                       InvalidArgument);
  b.update("flow", {0.0, 1.0});
  CHECK_THROWS_WITH_AS(b.update("flow", {0.0, 1.0}), doctest::Contains("given twice"), InvalidArgument);
}

TEST_CASE("with bdf2, dashpots flow for half a step at its start and half at its end") {
  Settings settings = settings_of();
  settings.time.integrator = Integrator::Bdf2;
  Simulation simulation(scene_of_maxwell(), settings);
  REQUIRE_FALSE(simulation.step().failed());  // by implicit Euler
  for (int n = 0; n < 20; ++n) {
    const State before = simulation.state();
    REQUIRE_FALSE(simulation.step().failed());
    const auto flowed = [](double ratio, double x, double flow) {
      return flow + ratio / (1.0 + ratio) * (x - flow);
    };
    const double x = before.body_position[0].x, start = before.internal_variable[0];
    const double half = flowed(0.05, x, start);
    const double first = half + (flowed(0.05, x, half) - flowed(0.1, x, start));
    const double end = simulation.state().body_position[0].x;
    CHECK(simulation.state().internal_variable[0] == Approx(flowed(0.05, end, first)).epsilon(1e-9));
    CHECK(simulation.report().energy.damping > 0.0);
  }
}
