// Energies of the user's own: points of every kind, values shared or by element, live changes, refusals.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include <stark/stark.h>

using namespace stark;
using doctest::Approx;

namespace {

PotentialDefinition spring() {
  PotentialDefinition definition = define_potential("spring", 2, "Hookean spring", [](PotentialBuilder& b) {
    const auto k = b.parameter("stiffness", "N/m", "stiffness");
    const auto rest = b.parameter("rest_length", "m", "length without force");
    const auto stretch = symbolic::norm(b.x(1) - b.x(0)) - rest;
    return 0.5 * k * stretch * stretch;
  });
  return definition;
}

PotentialDefinition anchor() {
  PotentialDefinition definition =
      define_potential("anchor", 1, "spring to a point", [](PotentialBuilder& b) {
        return 0.5 * b.parameter("stiffness", "N/m", "stiffness") *
               symbolic::squared_norm(b.x(0) - b.parameter3("centre", "m", "centre"));
      });
  definition.translation_invariant = false;
  return definition;
}

Settings free_flight(double h) {
  Settings settings;
  settings.time.step = h;
  settings.gravity = {};
  settings.contact.enabled = false;
  settings.newton.step_tolerance = 1e-12;
  return settings;
}

RigidDescription unit_box() {
  return {.mesh = make_box({0.1, 0.1, 0.1}), .mass = 1.0, .position = {1.0, 0.0, 0.0}};
}

}  // namespace

TEST_CASE("a rigid body on a spring follows implicit Euler's own solution") {
  Scene scene;
  const BodyId box = scene.add_rigid(unit_box());
  scene.add_energy({.potential = anchor(),
                    .points = {body_points(box, {{0, 0, 0}})},
                    .values = {{"stiffness", {{100.0}}}, {"centre", {{0.0, 0.0, 0.0}}}}});
  Simulation simulation(scene, free_flight(0.01));
  double x = 1.0, v = 0.0;
  for (int n = 0; n < 100; ++n) {
    REQUIRE_FALSE(simulation.step().failed());
    v = (v - 0.01 * 100.0 * x) / (1.0 + 0.01 * 0.01 * 100.0);
    x += 0.01 * v;
    CHECK(simulation.position(box).x == Approx(x).epsilon(1e-9));
  }
  CHECK(x == Approx(-0.5209).epsilon(1e-3));  // V02 of the validation catalogue
}

TEST_CASE("a model traces a formula once, whatever the integrator") {
  for (const bool has_measure : {false, true}) {
    int count = 0;
    PotentialDefinition definition =
        define_potential("counted", 1, "spring or damper", [&](PotentialBuilder& b) {
          ++count;
          const auto r = has_measure ? symbolic::norm(b.x(0)) - symbolic::norm(b.x_prev(0)) : b.x(0)[0];
          return 0.5 * b.parameter("stiffness", "N/m", "stiffness") * r * r;
        });
    definition.translation_invariant = false;
    Scene scene;
    const BodyId box = scene.add_rigid(unit_box());
    scene.add_energy({.potential = definition,
                      .points = {body_points(box, {{0, 0, 0}})},
                      .values = {{"stiffness", {{100.0}}}}});
    std::vector<int> traces;
    for (const Integrator integrator : {Integrator::ImplicitEuler, Integrator::Bdf2}) {
      Settings settings = free_flight(0.01);
      settings.time.integrator = integrator;
      count = 0;
      const Simulation simulation(scene, settings);
      traces.push_back(count);
    }
    CHECK(traces[0] == traces[1]);
  }
}

TEST_CASE("one element between every two kinds of points, and their forces balance") {
  Scene scene;
  const BodyId cloth = scene.add_cloth({.mesh = make_grid(0.2, 0.2, 2, 2), .material = materials::cotton()});
  RigidDescription description = unit_box();
  description.position = {0.0, 0.0, 0.5};
  const BodyId box = scene.add_rigid(description);
  const PointSet sets[] = {
      vertex_points(cloth, {4}), vertex_points(box, {0}), body_points(box, {{0.05, 0, 0}}),
      embedded_points(cloth, {{0, 1, 3, 0}}, {{0.25, 0.25, 0.5, 0.0}}), world_points({{0.3, 0.1, 0.2}})};
  std::vector<EnergyId> ids;
  for (size_t a = 0; a < std::size(sets); ++a)
    for (size_t b = a + 1; b < std::size(sets); ++b)
      ids.push_back(scene.add_energy({.potential = spring(),
                                      .points = {sets[a], sets[b]},
                                      .values = {{"stiffness", {{2.0}}}, {"rest_length", {{0.05}}}}}));
  Simulation simulation(scene, free_flight(0.01));
  for (int n = 0; n < 5; ++n) REQUIRE_FALSE(simulation.step().failed());
  for (const EnergyId id : ids) {
    const std::vector<Vec3> forces = simulation.element_forces(id);
    REQUIRE(forces.size() == 2);
    CHECK(norm(forces[0] + forces[1]) <= 1e-12 * norm(forces[0]));
    CHECK(norm(forces[0]) > 0.0);
    CHECK(simulation.element_energies(id)[0] == Approx(squared_norm(forces[0]) / (2.0 * 2.0)).epsilon(1e-9));
  }
}

TEST_CASE("a direction turns with its body") {
  Scene scene;
  const BodyId box = scene.add_rigid(unit_box());
  PotentialDefinition align = define_potential(
      "align", 1, "", [](PotentialBuilder& b) { return -b.parameter("torque", "N m", "") * b.x(0)[1]; });
  align.translation_invariant = false;
  scene.add_energy(
      {.potential = align, .points = {body_directions(box, {{1, 0, 0}})}, .values = {{"torque", {{0.01}}}}});
  Simulation simulation(scene, free_flight(0.01));
  REQUIRE_FALSE(simulation.step().failed());
  // Torque 0.01 N m about z on a cube of 1 kg and 0.1 m: alpha = 6 tau / (m a^2) = 6 rad/s^2.
  CHECK(simulation.angular_velocity(box).z == Approx(0.06).epsilon(1e-3));
}

TEST_CASE("values by element act on their own element, and change without a new model") {
  Scene scene;
  std::vector<BodyId> boxes;
  for (int k = 0; k < 3; ++k) {
    RigidDescription description = unit_box();
    description.position = {1.0, 2.0 * k, 0.0};
    boxes.push_back(scene.add_rigid(description));
  }
  std::vector<EnergyId> pulls;
  for (int k = 0; k < 3; ++k)
    pulls.push_back(scene.add_energy(
        {.potential = anchor(),
         .points = {body_points(boxes[k], {{0, 0, 0}, {0, 0, 0}})},
         .values = {{"stiffness", {{1.0 * k, 2.0 * k}, true}}, {"centre", {{0.0, 2.0 * k, 0.0}}}}}));
  Simulation simulation(scene, free_flight(0.1));
  REQUIRE_FALSE(simulation.step().failed());
  for (int k = 0; k < 3; ++k) {
    const double stiffness = 3.0 * k;
    CHECK(simulation.linear_velocity(boxes[k]).x ==
          Approx(-0.1 * stiffness / (1.0 + 0.01 * stiffness)).epsilon(1e-9));
  }
  const double centre[] = {simulation.position(boxes[2]).x, 4.0, 0.0}, none[] = {0.0, 0.0};
  simulation.set_energy_value(pulls[2], "centre", centre);
  simulation.set_energy_value(pulls[1], "stiffness", none);
  const double before = simulation.linear_velocity(boxes[1]).x;
  REQUIRE_FALSE(simulation.step().failed());
  CHECK(simulation.linear_velocity(boxes[1]).x == Approx(before).epsilon(1e-12));
  CHECK_THROWS_AS(simulation.set_energy_value(pulls[1], "stiffnes", none), InvalidArgument);
  CHECK_THROWS_AS(simulation.set_energy_value(pulls[1], "stiffness", centre), InvalidArgument);
  const double bad[] = {1.0, std::numeric_limits<double>::quiet_NaN()};
  CHECK_THROWS_AS(simulation.set_energy_value(pulls[1], "stiffness", bad), InvalidArgument);
}

TEST_CASE("time and time step reach the formula") {
  Scene scene;
  const BodyId box = scene.add_rigid(unit_box());
  PotentialDefinition push = define_potential("push", 1, "", [](PotentialBuilder& b) {
    return -b.parameter("rate", "N/s", "") * b.time() * b.x(0)[2] +
           0.0 * b.time_step() * symbolic::squared_norm(b.velocity(0));
  });
  push.translation_invariant = false;
  const EnergyId id = scene.add_energy(
      {.potential = push, .points = {body_points(box, {{0, 0, 0}})}, .values = {{"rate", {{3.0}}}}});
  Simulation simulation(scene, free_flight(0.25));
  for (int n = 1; n <= 4; ++n) {
    REQUIRE_FALSE(simulation.step().failed());
    CHECK(simulation.element_forces(id)[0].z == Approx(3.0 * 0.25 * n).epsilon(1e-12));
  }
}

TEST_CASE("a point embedded between a moving pin and a free vertex follows both") {
  Scene scene;
  const BodyId cloth = scene.add_cloth({.mesh = make_grid(0.2, 0.2, 1, 1), .material = materials::cotton()});
  const int32_t pins[] = {0, 1, 2};
  scene.pin(cloth, pins);
  PotentialDefinition hold = anchor();
  const EnergyId id =
      scene.add_energy({.potential = hold,
                        .points = {embedded_points(cloth, {{0, 3, 0, 0}}, {{0.5, 0.5, 0.0, 0.0}})},
                        .values = {{"stiffness", {{1e4}}}, {"centre", {{0.0, 0.0, 0.0}}}}});
  Simulation simulation(scene, free_flight(0.01));
  std::vector<Vec3> targets = simulation.pin_targets(cloth);
  for (Vec3& target : targets) target.z += 0.01;
  simulation.set_pin_targets(cloth, targets);
  REQUIRE_FALSE(simulation.step().failed());
  const std::vector<Vec3> x = simulation.positions(cloth);
  CHECK(x[0].z == Approx(0.01));
  const Vec3 middle = (x[0] + x[3]) * 0.5;
  CHECK(norm(simulation.element_forces(id)[0] + middle * 1e4) <= 1e-9 * 1e4 * norm(middle));
  CHECK(std::fabs(middle.z) < 1e-3);
}

TEST_CASE("energies that cannot be evaluated are refused before the first step") {
  const auto build = [](PotentialDefinition potential, ParameterValues values) {
    Scene scene;
    const BodyId box = scene.add_rigid(unit_box());
    scene.add_energy({.potential = std::move(potential),
                      .points = {body_points(box, {{0, 0, 0}, {0.1, 0, 0}})},
                      .values = std::move(values)});
    Simulation simulation(scene, free_flight(0.01));
  };
  PotentialDefinition singular = define_potential(
      "singular", 1, "", [](PotentialBuilder& b) { return symbolic::log(b.x(0)[0] - 1.05) + b.x(0)[1]; });
  singular.translation_invariant = false;
  CHECK_THROWS_WITH_AS(build(singular, {}), doctest::Contains("'singular': element 0 has an energy of nan"),
                       InvalidArgument);
  PotentialDefinition undeclared = anchor();
  undeclared.translation_invariant = true;
  CHECK_THROWS_WITH_AS(build(undeclared, {{"stiffness", {{1.0}}}, {"centre", {{0, 0, 0}}}}),
                       doctest::Contains("translation_invariant = false"), InvalidArgument);
}

TEST_CASE("wrong points and values are refused when the energy is added") {
  Scene scene;
  const BodyId box = scene.add_rigid(unit_box());
  const BodyId cloth = scene.add_cloth({.mesh = make_grid(0.2, 0.2, 2, 2), .material = materials::cotton()});
  const ParameterValues good{{"stiffness", {{1.0}}}, {"rest_length", {{1.0}}}};
  const auto refused = [&](std::vector<PointSet> points, ParameterValues values, const char* text) {
    CHECK_THROWS_WITH_AS(
        scene.add_energy({.potential = spring(), .points = std::move(points), .values = std::move(values)}),
        doctest::Contains(text), InvalidArgument);
    CHECK(scene.energies().empty());
  };
  const PointSet one = vertex_points(cloth, {0}), two = vertex_points(cloth, {0, 1});
  refused({one}, good, "must be one for each point");
  refused({one, vertex_points(cloth, {9})}, good, "must be in [0, 9)");
  refused({one, body_points(cloth, {{0, 0, 0}})}, good, "only rigid bodies");
  refused({two, vertex_points(cloth, {0, 1, 2})}, good, "same number of points");
  refused({vertex_points(cloth, {}), vertex_points(cloth, {})}, good, "at least one");
  refused({one, embedded_points(cloth, {{0, 1, 2, 2}}, {{0.5, 0.2, 0.2, 0.0}})}, good, "must sum to 1");
  refused({one, embedded_points(box, {{0, 1, 2, 2}}, {{0.5, 0.2, 0.3, 0.0}})}, good, "cloth and solids only");
  refused({one, two}, {{"stiffness", {{1.0}}}}, "'rest_length' [m] is missing");
  refused({one, two}, {{"stiffness", {{1.0}}}, {"rest_length", {{1.0, 2.0}}}}, "must be 1");
  refused({one, two}, {{"stiffness", {{1.0}, true}}, {"rest_length", {{1.0}}}},
          "1 for each of the 2 elements");
  refused({one, two}, {{"stiffness", {{1.0}}}, {"rest_length", {{1.0}}}, {"stifness", {{1.0}}}}, "stiffness");
  CHECK(scene.add_energy({.potential = spring(), .points = {one, two}, .values = good}).index == 0);
  CHECK(scene.add_energy({.potential = spring(), .points = {one, two}, .values = good}).index == 1);
  CHECK(scene.energy({1}).name == "spring_2");
}
