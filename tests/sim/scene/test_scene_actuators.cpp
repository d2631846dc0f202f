// Scene: actuators. Names, coordinates, values; every refusal names the actuator and the remedy.
#include <doctest/doctest.h>

#include <cmath>

#include <stark/base/error.h>
#include <support/joint_scenes.h>

using namespace stark;
using namespace stark::test;
using doctest::Contains;

namespace {

ActuatorDescription effort_on(JointId joint, const std::string& coordinate = "") {
  return {.definition = find_actuator("effort"), .on = {{joint, coordinate}}, .values = {{"target", 1.0}}};
}

}  // namespace

TEST_CASE("actuators are named after their kind, numbered, and know their coordinate") {
  Machine m = machine("hinge", wheel(0.01));
  const ActuatorId first = m.scene.add_actuator(effort_on(m.joint)),
                   second = m.scene.add_actuator(effort_on(m.joint));
  CHECK(m.scene.actuator(first).name == "effort");
  CHECK(m.scene.actuator(second).name == "effort_2");
  CHECK(m.scene.actuator(first).on[0].name == "angle");
  CHECK(m.scene.actuator(first).values.at("target") == 1.0);
  ActuatorDescription taken = effort_on(m.joint);
  taken.name = "effort";
  CHECK_THROWS_WITH_AS(m.scene.add_actuator(taken), Contains("the name is taken"), InvalidArgument);
}

TEST_CASE("coordinates that are not there are refused") {
  Machine m = machine("cylindrical", wheel(0.01)), ball = machine("ball", wheel(0.01));
  CHECK_THROWS_WITH_AS(m.scene.add_actuator(effort_on(m.joint)),
                       Contains("coordinates 'displacement', 'angle': must name the one"), InvalidArgument);
  CHECK_THROWS_WITH_AS(m.scene.add_actuator(effort_on(m.joint, "angel")), Contains("did you mean 'angle'"),
                       InvalidArgument);
  CHECK_THROWS_WITH_AS(ball.scene.add_actuator(effort_on(ball.joint)),
                       Contains("has no coordinate to act on"), InvalidArgument);
  CHECK_THROWS_AS(m.scene.add_actuator(effort_on({7}, "angle")), InvalidArgument);
  ActuatorDescription gear{
      .definition = find_actuator("gear"), .on = {{m.joint, "angle"}}, .values = {{"ratio", 1}}};
  CHECK_THROWS_WITH_AS(m.scene.add_actuator(gear), Contains("on 1 coordinates: must be on 2"),
                       InvalidArgument);
  CHECK(m.scene.actuators().empty());
}

TEST_CASE("values are checked when they are given") {
  Machine m = machine("hinge", wheel(0.01));
  const auto motor = [&](std::map<std::string, double> values) {
    return add(m.scene, "velocity_motor", m.joint, std::move(values));
  };
  CHECK_THROWS_WITH_AS(motor({{"target", 1}, {"cap", 1}}), Contains("'delta' [rad/s] is missing"),
                       InvalidArgument);
  CHECK_THROWS_WITH_AS(motor({{"target", 1}, {"cap", -1}, {"delta", 1}}), Contains("cap = -1 N m"),
                       InvalidArgument);
  CHECK_THROWS_WITH_AS(motor({{"target", NAN}, {"cap", 1}, {"delta", 1}}), Contains("target = nan rad/s"),
                       InvalidArgument);
  CHECK_THROWS_WITH_AS(motor({{"target", 1}, {"cap", 1}, {"delta", 1}, {"torque", 1}}),
                       Contains("unknown value 'torque'"), InvalidArgument);
  CHECK_THROWS_WITH_AS(m.scene.add_actuator({.name = "nothing", .on = {{m.joint}}}),
                       Contains("'nothing': has no definition"), InvalidArgument);
  CHECK_THROWS_WITH_AS(find_actuator("velocity_moter"), Contains("did you mean 'velocity_motor'"),
                       InvalidArgument);
  const ActuatorId id = motor({{"target", 1}, {"cap", 1}, {"delta", 1}});
  m.scene.set_actuator_value(id, "target", 4.0);
  CHECK(m.scene.actuator_value(id, "target") == 4.0);
  m.scene.set_actuator_enabled(id, false);
  CHECK_THROWS_WITH_AS(m.scene.set_actuator_value(id, "delta", 0.0), Contains("delta = 0 rad/s: must be > 0"),
                       InvalidArgument);
  CHECK_THROWS_WITH_AS(m.scene.set_actuator_value(id, "speed", 0.0), Contains("unknown value 'speed'"),
                       InvalidArgument);
  CHECK_THROWS_WITH_AS(add(m.scene, "limit", m.joint, {{"lower", 1}, {"upper", -1}}),
                       Contains("lower must not be above upper"), InvalidArgument);
  const ActuatorId stops = add(m.scene, "limit", m.joint, {{"lower", -1}, {"upper", 1}});
  CHECK_THROWS_WITH_AS(m.scene.set_actuator_value(stops, "upper", -2.0),
                       Contains("lower must not be above upper"), InvalidArgument);
  CHECK_THROWS_AS(m.scene.set_actuator_value({9}, "target", 0.0), InvalidArgument);
  Simulation simulation(m.scene, machine_settings(0.01));
  CHECK_THROWS_WITH_AS(simulation.set_actuator_value(stops, "lower", 2.0),
                       Contains("lower must not be above upper"), InvalidArgument);
  CHECK(simulation.actuator_value(stops, "lower") == -1.0);
  CHECK(simulation.actuator_value(id, "target") == 4.0);
  CHECK(simulation.actuator_value(id, "delta") == 1.0);
  CHECK_FALSE(simulation.actuator_enabled(id));
}
