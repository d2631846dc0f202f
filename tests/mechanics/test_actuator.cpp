// Actuators as formulas: which points are left, turns, memories, rows, efforts; from formulas of one point.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include <stark/base/error.h>
#include <stark/mechanics/define.h>

using namespace stark;
using doctest::Approx;
using symbolic::Backend;
using symbolic::Order;

namespace {

JointDefinition pin() {
  return define_joint("pin", "", [](JointBuilder& j) {
    j.hold(j.a.origin - j.b.origin, ResidualUnit::Length);
    j.coordinate("angle", symbolic::atan2(symbolic::dot(j.b.x, j.a.y), symbolic::dot(j.b.x, j.a.x)), "rad");
    j.coordinate("height", symbolic::dot(j.a.z, j.b.origin - j.a.origin), "m");
  });
}

ActuatorDefinition spring() {
  return define_actuator("spring", "", [](ActuatorBuilder& a) {
    const auto k = a.parameter("stiffness", a.stiffness_unit(), "how stiff", positive());
    return 0.5 * k * symbolic::square(a.q() - a.parameter("rest", a.unit(), "where", any_number(), 0.25));
  });
}

/// Effort of a spring of 2 N m/rad with b turned by `angle`, the step starting at `start` (`counted` with all
/// turns).
double spring_effort(double angle, double start, double counted) {
  const JointDefinition joint = pin();
  const Actuator law(spring(), {{&joint, 0, FrameKind::Axes, FrameKind::Axes}}, Backend::Automatic);
  // a.x, a.y and b.x are all that the angle needs.
  CHECK(law.points() == std::vector<int>{1, 2, 5});
  PotentialBatch batch(law.potential());
  const int32_t stencil[] = {0, 1, 2};
  batch.resize(stencil);
  batch.set(actuator_parameter_field("stiffness"), 0, 2.0);
  batch.set(actuator_parameter_field("rest"), 0, 0.0);
  batch.set("active", 0, 1.0);
  batch.set(actuator_raw_start_field(0), 0, start);
  batch.set(actuator_start_field(0), 0, counted);
  const std::vector<Vec3> x{{1, 0, 0}, {0, 1, 0}, {std::cos(angle), std::sin(angle), 0}};
  const std::vector<double> gradient = batch.evaluate(Order::Gradient, x);
  // Turning b.x by a small angle moves it along (-sin, cos): the torque on b is minus the gradient along it.
  const double torque = gradient[1 + 6] * std::sin(angle) - gradient[1 + 7] * std::cos(angle);
  const double effort = batch.evaluate(law.values(), x)[0];
  CHECK(torque == Approx(effort));
  batch.set("active", 0, 0.0);
  CHECK(batch.evaluate(law.values(), x)[0] == 0.0);
  CHECK(batch.evaluate(Order::Gradient, x)[1 + 7] == 0.0);
  return effort;
}

}  // namespace

TEST_CASE("angles are counted over full turns") {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  CHECK(spring_effort(0.3, 0.1, 0.1) == Approx(-2.0 * 0.3));
  CHECK(spring_effort(0.3, 0.1, 0.1 + 3 * kTurn) == Approx(-2.0 * (0.3 + 3 * kTurn)));
  // Across the jump of atan2, in both directions.
  CHECK(spring_effort(-3.1, 3.1, 3.1) == Approx(-2.0 * (kTurn - 3.1)));
  CHECK(spring_effort(3.1, -3.1, -3.1) == Approx(-2.0 * (3.1 - kTurn)));
}

TEST_CASE("units of parameters follow the coordinate") {
  const auto along_angle = actuator_parameters(spring(), {"rad"});
  CHECK(along_angle[0].unit == "N m/rad");
  CHECK(along_angle[1].unit == "rad");
  CHECK(along_angle[1].fallback == 0.25);
  CHECK_FALSE(along_angle[0].fallback.has_value());
  CHECK(actuator_parameters(spring(), {"m"})[0].unit == "N/m");
}

TEST_CASE("an actuator has rows for its residuals, whose forces are part of the effort") {
  const ActuatorDefinition stop = define_actuator("stop", "", [](ActuatorBuilder& a) {
    a.limit(a.q() - 0.5);
    return -1.5 * a.dq();
  });
  const JointDefinition joint = pin();
  const Actuator law(stop, {{&joint, 1, FrameKind::Axes, FrameKind::Axes}}, Backend::Interpreter);
  CHECK(law.units() == std::vector<ResidualUnit>{ResidualUnit::Length});
  CHECK(law.one_sided() == std::vector<char>{1});
  PotentialBatch batch(law.potential());
  const int32_t stencil[] = {0, 1, 2};  // a.origin, a.z, b.origin
  batch.resize(stencil);
  batch.set("active", 0, 1.0);
  batch.set("multiplier", 0, 2.0);
  batch.set("penalty", 0, 10.0);
  const auto values_at = [&](double height) {
    return batch.evaluate(law.values(), std::vector<Vec3>{{0, 0, 0}, {0, 0, 1}, {0, 0, height}});
  };
  CHECK(values_at(0.6)[0] == Approx(0.1));              // residual
  CHECK(values_at(0.6)[1] == Approx(1.5 - 2.0 - 1.0));  // pushes back with lambda + rho C
  CHECK(values_at(0.4)[1] == Approx(1.5 - 2.0 + 1.0));  // lets go as the gap opens
  CHECK(values_at(0.1)[1] == Approx(1.5));              // and never pulls
}

TEST_CASE("memories become what the formula says") {
  const ActuatorDefinition counter = define_actuator("counter", "", [](ActuatorBuilder& a) {
    const auto steps = a.memory("steps", "1", "how many");
    a.remember("steps", steps + 1.0);
    return steps * a.dq();
  });
  const JointDefinition joint = pin();
  const Actuator law(counter, {{&joint, 1, FrameKind::Axes, FrameKind::Axes}}, Backend::Interpreter);
  CHECK(law.memories() == std::vector<std::string>{"steps"});
  PotentialBatch batch(law.potential());
  const int32_t stencil[] = {0, 1, 2};
  batch.resize(stencil);
  batch.set("active", 0, 1.0);
  batch.set(actuator_memory_field("steps"), 0, 4.0);
  const std::vector<double> values =
      batch.evaluate(law.values(), std::vector<Vec3>{{0, 0, 0}, {0, 0, 1}, {0, 0, 0.2}});
  CHECK(values == std::vector<double>{-4.0, 5.0});  // effort, next memory

  const ActuatorDefinition forgetful = define_actuator("forgetful", "", [](ActuatorBuilder& a) {
    a.remember("steps", 1.0);
    return a.dq();
  });
  CHECK_THROWS_WITH_AS(actuator_parameters(forgetful, {"m"}), doctest::Contains("must be declared"),
                       InvalidArgument);
}

TEST_CASE("an actuator from a formula of one point is the same actuator") {
  const auto traced = std::make_shared<PotentialBuilder>(1);
  const symbolic::Scalar start = traced->data("coordinate.0", "", "at the start");
  const symbolic::Scalar k = traced->parameter("stiffness", "N/m", "how stiff", positive());
  const symbolic::Scalar rest = traced->parameter("rest", "m", "where");
  const symbolic::Scalar energy = 0.5 * k * symbolic::square(start + traced->x(0)[0] - rest);
  const ActuatorDefinition again =
      define_actuator("again", "", Formula(traced, {energy}), {.fallbacks = {{"rest", 0.25}}});
  CHECK(again.coordinate_count == 1);
  const auto parameters = actuator_parameters(again, {"m"});
  REQUIRE(parameters.size() == 2);
  CHECK(parameters[0].rule.text() == actuator_parameters(spring(), {"m"})[0].rule.text());
  CHECK(parameters[1].fallback == 0.25);
  const JointDefinition joint = pin();
  const std::vector<JointCoordinate> on{{&joint, 1, FrameKind::Axes, FrameKind::Axes}};
  std::vector<std::vector<double>> results;
  for (const ActuatorDefinition& definition : {spring(), again}) {
    const Actuator law(definition, on, Backend::Automatic);
    PotentialBatch batch(law.potential());
    const int32_t stencil[] = {0, 1, 2};
    batch.resize(stencil);
    batch.set("active", 0, 1.0);
    batch.set(actuator_parameter_field("stiffness"), 0, 7.0);
    batch.set(actuator_parameter_field("rest"), 0, 0.1);
    batch.set(actuator_start_field(0), 0, 0.3);
    batch.set(actuator_raw_start_field(0), 0, 0.3);
    results.push_back(batch.evaluate(Order::Hessian, std::vector<Vec3>{{0, 0, 0}, {0, 0, 1}, {0, 0, 0.4}}));
  }
  CHECK(results[0] == results[1]);
}
