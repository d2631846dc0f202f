// Actuators in motion, against closed forms and the recursions of implicit Euler.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include <stark/stark.h>
#include <support/joint_scenes.h>
#include <support/simulation_checks.h>

using namespace stark;
using namespace stark::test;
using doctest::Approx;

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

void step(Simulation& simulation) {
  const StepReport& report = simulation.step();
  INFO(report.brief());
  REQUIRE_MESSAGE(report.status == StepStatus::Accepted, report.message);
}

/// Effort of the motor of the paper's figure 2.
double motor_effort(double target, double rate, double cap, double delta) {
  return std::clamp(cap / delta * (target - rate), -cap, cap);
}

}  // namespace

TEST_CASE("the motor of a flywheel follows the profiles of torque and velocity") {
  // Robot wheel of the paper: 66.6 mN m, 7.43 rad/s; 0.01 kg m^2 make 6.66 rad/s^2.
  const double I = 0.01, cap = 66.6e-3, target = 7.43, delta = 1.0;
  for (const double h : {1e-2, 1e-4}) {
    Machine m = machine("hinge", wheel(I));
    const ActuatorId motor =
        add(m.scene, "velocity_motor", m.joint, {{"target", target}, {"cap", cap}, {"delta", delta}});
    Simulation simulation(m.scene, machine_settings(h, 1e-12 / (h * h)));
    double speed = 0.0;  // of the angular momentum [rad/s]
    while (simulation.time() < 1.5) {
      step(simulation);
      const double rate = simulation.joint_rates(m.joint)[0], t = simulation.time();
      const double effort = simulation.actuator_effort(motor);
      CHECK(effort <= cap * (1.0 + 1e-9));
      CHECK(effort == Approx(motor_effort(target, rate, cap, delta)).epsilon(1e-9));
      CHECK(simulation.actuator_power(motor) == Approx(effort * rate));
      // Inertia resists the turn away from free motion: I sin(turn - h speed) / h^2 = effort, h effort goes
      // into the momentum. With 1e-4 s the rounding of the axes times the penalty of the hinge, 1e4 I / h^2,
      // already shows in the fourth digit.
      const double turn = h * rate;
      if (h > 1e-3) CHECK(std::fabs(I * std::sin(turn - h * speed) / (h * h) - effort) < 1e-9);
      speed += h * effort / I;
      CHECK(norm(simulation.angular_velocity({0})) == Approx(speed).epsilon(1e-6));
      const double t1 = (target - delta) / (cap / I);  // 0.965 s
      const double exact = t < t1 ? cap / I * t : target - delta * std::exp(-cap / I / delta * (t - t1));
      if (h < 1e-3) CHECK(std::fabs(rate - exact) < 1e-3 * target);
    }
  }
}

TEST_CASE("the rate of a carriage obeys the closed form of every step") {
  const double mass = 2.0, cap = 3.0, target = 0.8, delta = 0.5, h = 0.01;
  RigidDescription body = wheel(1.0, {}, mass);
  body.velocity = {0, 0, -0.3};
  Machine m = machine("slider", body);
  const ActuatorId motor =
      add(m.scene, "velocity_motor", m.joint, {{"target", target}, {"cap", cap}, {"delta", delta}});
  Simulation simulation(m.scene, machine_settings(h));
  double v = -0.3;
  for (int n = 0; n < 200; ++n) {
    step(simulation);
    // v' = v + h F(v') / m: constant force, or linear in v'.
    const double k = cap / delta, linear = (v + h * k * target / mass) / (1.0 + h * k / mass);
    v = target - linear > delta ? v + h * cap / mass : linear;
    CHECK(simulation.joint_rates(m.joint)[0] == Approx(v).epsilon(1e-9));
    CHECK(simulation.actuator_effort(motor) <= cap * (1.0 + 1e-9));
  }
}

TEST_CASE("a blocked press pushes with its cap") {
  Machine m = machine("slider", wheel(0.01));
  const ActuatorId motor =
      add(m.scene, "velocity_motor", m.joint, {{"target", 0.1}, {"cap", 5.0}, {"delta", 0.05}});
  const ActuatorId stop = add(m.scene, "upper_limit", m.joint, {{"upper", 0.02}});
  Simulation simulation(m.scene, machine_settings(0.01, 1e-6));
  for (int n = 0; n < 100; ++n) step(simulation);
  CHECK(simulation.joint_coordinates(m.joint)[0] == Approx(0.02).epsilon(1e-4));
  CHECK(simulation.actuator_effort(motor) == Approx(5.0).epsilon(1e-12));
  CHECK(simulation.actuator_effort(stop) == Approx(-5.0).epsilon(1e-6));
  simulation.set_actuator_value(motor, "target", -0.1);
  for (int n = 0; n < 10; ++n) step(simulation);
  CHECK(simulation.joint_coordinates(m.joint)[0] < 0.02);  // a stop does not hold on
  CHECK(simulation.actuator_effort(stop) == 0.0);
}

TEST_CASE("a PD servo moves as the recursion of implicit Euler and rests where gains and load balance") {
  const double mass = 1.5, kp = 80.0, kd = 6.0, h = 0.01, g = 9.81, target = 0.2;
  Machine m = machine("slider", wheel(1.0, {}, mass));
  const ActuatorId servo = add(m.scene, "position_servo", m.joint,
                               {{"target", target}, {"stiffness", kp}, {"damping", kd}, {"cap", 1e3}});
  Settings settings = machine_settings(h);
  settings.gravity = {0, 0, -g};
  Simulation simulation(m.scene, settings);
  double q = 0.0, v = 0.0;
  for (int n = 0; n < 400; ++n) {
    step(simulation);
    // m (v' - v) / h = kp (target - q - h v') - kd v' - m g
    v = (mass * v / h + kp * (target - q) - mass * g) / (mass / h + kp * h + kd);
    q += h * v;
    CHECK(simulation.joint_coordinates(m.joint)[0] == Approx(q).epsilon(1e-9));
  }
  CHECK(simulation.joint_coordinates(m.joint)[0] == Approx(target - mass * g / kp).epsilon(1e-3));
  CHECK(simulation.actuator_effort(servo) == Approx(mass * g).epsilon(1e-3));
}

TEST_CASE("a servo under its cap pushes with the cap, and its integral takes the error away") {
  const double g = 9.81;
  Machine m = machine("slider", wheel(1.0));
  const ActuatorId servo =
      add(m.scene, "position_servo", m.joint,
          {{"target", 0.3}, {"stiffness", 200.0}, {"damping", 30.0}, {"integral", 300.0}, {"cap", 12.0}});
  Settings settings = machine_settings(0.01);
  settings.gravity = {0, 0, -g};
  Simulation simulation(m.scene, settings);
  step(simulation);
  CHECK(simulation.actuator_effort(servo) == Approx(12.0).epsilon(1e-12));
  CHECK(simulation.state().actuator_memory[0] == 0.0);  // does not wind up
  for (int n = 0; n < 1500; ++n) {
    step(simulation);
    CHECK(std::fabs(simulation.actuator_effort(servo)) <= 12.0 * (1.0 + 1e-9));
  }
  CHECK(simulation.joint_coordinates(m.joint)[0] == Approx(0.3).epsilon(1e-6));
  CHECK(simulation.actuator_effort(servo) == Approx(g).epsilon(1e-6));
}

TEST_CASE("a servo turns to a target that is many turns away") {
  Machine m = machine("hinge", wheel(0.01));
  const double target = 5.25 * kTurn;
  const ActuatorId servo = add(m.scene, "position_servo", m.joint,
                               {{"target", target}, {"stiffness", 1.0}, {"damping", 0.2}, {"cap", 1.0}});
  Simulation simulation(m.scene, machine_settings(0.01));
  for (int n = 0; n < 600; ++n) {
    step(simulation);
    CHECK(std::fabs(simulation.actuator_effort(servo)) <= 1.0 + 1e-9);
  }
  CHECK(simulation.joint_coordinates(m.joint)[0] == Approx(target).epsilon(1e-5));
  simulation.set_actuator_value(servo, "target", -kTurn);
  for (int n = 0; n < 600; ++n) step(simulation);
  CHECK(simulation.joint_coordinates(m.joint)[0] == Approx(-kTurn).epsilon(1e-5));
}

TEST_CASE("a given torque accelerates, and an armature adds to the inertia") {
  const double I = 0.02, J = 0.03, torque = 0.4, h = 1e-3;
  for (const bool has_armature : {false, true}) {
    Machine m = machine("hinge", wheel(I));
    const ActuatorId drive = add(m.scene, "effort", m.joint, {{"target", torque}});
    if (has_armature) add(m.scene, "armature", m.joint, {{"inertia", J}});
    Simulation simulation(m.scene, machine_settings(h));
    for (int n = 0; n < 200; ++n) step(simulation);
    const double expected = torque / (I + (has_armature ? J : 0.0)) * 0.2;
    CHECK(simulation.joint_rates(m.joint)[0] == Approx(expected).epsilon(1e-3));
    CHECK(simulation.actuator_effort(drive) == Approx(torque).epsilon(1e-12));
  }
}

TEST_CASE("an armature keeps its speed from time 0 on") {
  RigidDescription body = wheel(0.02);
  body.angular_velocity = {0, 0, 3.0};
  Machine m = machine("hinge", body);
  add(m.scene, "armature", m.joint, {{"inertia", 0.5}});
  Simulation simulation(m.scene, machine_settings(1e-3));
  for (int n = 0; n < 50; ++n) step(simulation);
  CHECK(simulation.joint_rates(m.joint)[0] == Approx(3.0).epsilon(1e-4));
}

TEST_CASE("dry friction brings a wheel and a carriage to rest where constant deceleration ends") {
  const double rate = 1.0, deceleration = 1.0, h = 1e-3;
  for (const std::string kind : {"hinge", "slider"}) {
    CAPTURE(kind);
    RigidDescription body = wheel(0.01);
    (kind == "hinge" ? body.angular_velocity : body.velocity) = {0, 0, rate};
    const double cap = deceleration * (kind == "hinge" ? 0.01 : 1.0);
    Machine m = machine(kind, body);
    const ActuatorId friction = add(m.scene, "joint_friction", m.joint, {{"cap", cap}, {"stick_rate", 1e-4}});
    Simulation simulation(m.scene, machine_settings(h, 1e-5));
    while (simulation.time() < 1.1) {
      step(simulation);
      CHECK(std::fabs(simulation.actuator_effort(friction)) <= cap * (1.0 + 1e-9));
    }
    CHECK(std::fabs(simulation.joint_rates(m.joint)[0]) < 1e-6);
    // rate^2 / (2 deceleration), less half a step of the initial rate as implicit Euler has it. Of a rotation
    // it takes away h rate^3 more of the rate in each second.
    const double expected = rate * rate / (2.0 * deceleration) - 0.5 * h * rate;
    CHECK(simulation.joint_coordinates(m.joint)[0] ==
          Approx(expected).epsilon(kind == "hinge" ? 1e-3 : 1e-5));
  }
}

TEST_CASE("a loaded joint under friction creeps slower than the stick rate") {
  Machine m = machine("hinge", wheel(0.01));
  const ActuatorId friction = add(m.scene, "joint_friction", m.joint, {{"cap", 1.0}, {"stick_rate", 1e-3}});
  add(m.scene, "effort", m.joint, {{"target", 0.75}});
  Simulation simulation(m.scene, machine_settings(0.01));
  for (int n = 0; n < 50; ++n) step(simulation);
  CHECK(simulation.actuator_effort(friction) == Approx(-0.75).epsilon(1e-9));
  CHECK(simulation.joint_rates(m.joint)[0] == Approx(0.5e-3).epsilon(1e-4));  // 2 s - s^2 = 0.75
}

TEST_CASE("stops hold a pendulum on both sides and carry its weight") {
  // Horizontal arm of 1 m, gravity along -y; hinge along z, stops at -0.4 and 1.1 rad.
  const double g = 9.81;
  RigidDescription body = wheel(0.01, {1, 0, 0});
  Scene scene;
  const BodyId bob = scene.add_rigid(body);
  const JointId hinge = scene.add_joint(
      {.definition = find_joint("hinge"), .a = world_frame({0, 0, 0}), .b = body_frame(bob, {-1, 0, 0})});
  const ActuatorId stops = add(scene, "limit", hinge, {{"lower", -0.4}, {"upper", 1.1}});
  Settings settings = machine_settings(0.01, 1e-6);
  for (const double sign : {-1.0, 1.0}) {
    settings.gravity = {0, sign * g, 0};
    Simulation simulation(scene, settings);
    const double stop = sign > 0 ? 1.1 : -0.4;
    double extreme = 0.0;
    for (int n = 0; n < 300; ++n) {
      step(simulation);
      extreme = std::max(extreme, sign * simulation.joint_coordinates(hinge)[0]);
    }
    CHECK(extreme <= std::fabs(stop) + 1e-5);
    CHECK(simulation.joint_coordinates(hinge)[0] == Approx(stop).epsilon(1e-4));
    CHECK(simulation.actuator_effort(stops) == Approx(-sign * g * std::cos(stop)).epsilon(1e-5));
  }
}

TEST_CASE("limits beyond a turn, and released joints without their actuators") {
  Machine m = machine("hinge", wheel(0.01));
  const double stop = 2.5 * kTurn;
  add(m.scene, "upper_limit", m.joint, {{"upper", stop}});
  const ActuatorId drive = add(m.scene, "effort", m.joint, {{"target", 0.3}});
  Simulation simulation(m.scene, machine_settings(0.01, 1e-6));
  for (int n = 0; n < 200; ++n) step(simulation);
  CHECK(simulation.joint_coordinates(m.joint)[0] == Approx(stop).epsilon(1e-6));
  simulation.set_joint_enabled(m.joint, false);
  step(simulation);
  CHECK(simulation.actuator_effort(drive) == 0.0);
  simulation.set_joint_enabled(m.joint, true);
  simulation.set_actuator_enabled(drive, false);
  CHECK_FALSE(simulation.actuator_enabled(drive));
  step(simulation);
  CHECK(simulation.actuator_effort(drive) == 0.0);
}

TEST_CASE("a motor between two free bodies changes no momentum") {
  Scene scene;
  const BodyId a = scene.add_rigid(wheel(0.03, {0, 0, 0})), b = scene.add_rigid(wheel(0.01, {0, 0, 0.5}));
  const Mat3 tilted = exp_rotation({0.4, 0.0, 0.0});
  const JointId hinge = scene.add_joint({.definition = find_joint("hinge"),
                                         .a = body_frame(a, {0, 0, 0.25}, tilted),
                                         .b = body_frame(b, {0, 0, -0.25}, tilted)});
  const ActuatorId motor = add(scene, "velocity_motor", hinge, {{"target", 5}, {"cap", 0.1}, {"delta", 1}});
  Simulation simulation(scene, machine_settings(1e-3));
  for (int n = 0; n < 300; ++n) {
    step(simulation);
    CHECK(std::fabs(simulation.actuator_effort(motor)) <= 0.1 * (1.0 + 1e-9));
  }
  CHECK(simulation.joint_rates(hinge)[0] > 1.0);
  CHECK(norm(linear_momentum(simulation)) < 1e-9);
  Vec3 L;
  for (const auto& [body, index] : {std::pair{a, 0}, std::pair{b, 1}})
    L += spin(simulation, index) + cross(simulation.position(body), simulation.linear_velocity(body));
  // Implicit Euler of rotations conserves the angular momentum to second order in the turn of a step.
  CHECK(norm(L) < 1e-3 * norm(spin(simulation, 1)));
}

TEST_CASE("actuators act between a body and a patch of cloth") {
  Scene scene;
  ShellMaterial stiff = materials::cotton();
  stiff.density = 5.0;
  const BodyId cloth = scene.add_cloth({.mesh = make_grid(0.4, 0.4, 4, 4), .material = stiff});
  const int32_t pins[] = {0, 4, 20, 24};
  scene.pin(cloth, pins);
  const BodyId body = scene.add_rigid(wheel(1e-3, {0, 0, 0.1}, 0.1));
  const JointId slider = scene.add_joint({.definition = find_joint("slider"),
                                          .a = patch_frame(cloth, {12, 13, 18}, {0, 0, 0.1}),
                                          .b = body_frame(body, {})});
  const ActuatorId press =
      add(scene, "velocity_motor", slider, {{"target", 0.5}, {"cap", 0.2}, {"delta", 0.1}});
  add(scene, "limit", slider, {{"lower", -0.01}, {"upper", 0.05}});
  Simulation simulation(scene, machine_settings(0.01, 1e-6));
  for (int n = 0; n < 100; ++n) {
    step(simulation);
    CHECK(std::fabs(simulation.actuator_effort(press)) <= 0.2 * (1.0 + 1e-9));
    CHECK(simulation.joint_coordinates(slider)[0] <= 0.05 + 1e-6);
  }
  CHECK(simulation.joint_coordinates(slider)[0] == Approx(0.05).epsilon(1e-3));
}

TEST_CASE("a gear couples two wheels") {
  const double I = 0.01, I_far = 0.03, ratio = -2.5, torque = 0.2;
  Scene scene;
  const BodyId a = scene.add_rigid(wheel(I)), b = scene.add_rigid(wheel(I_far, {1, 0, 0}));
  const auto hinge = [&](BodyId body, const Vec3& at) {
    return scene.add_joint(
        {.definition = find_joint("hinge"), .a = world_frame(at), .b = body_frame(body, {})});
  };
  const JointId near = hinge(a, {}), far = hinge(b, {1, 0, 0});
  const ActuatorId gear = scene.add_actuator(
      {.definition = find_actuator("gear"), .on = {{far}, {near}}, .values = {{"ratio", ratio}}});
  add(scene, "effort", near, {{"target", torque}});
  Simulation simulation(scene, machine_settings(1e-3));
  for (int n = 0; n < 400; ++n) {
    step(simulation);
    CHECK(std::fabs(simulation.joint_coordinates(far)[0] - ratio * simulation.joint_coordinates(near)[0]) <=
          1e-5);
  }
  const double acceleration = torque / (I + ratio * ratio * I_far);
  CHECK(simulation.joint_rates(near)[0] == Approx(acceleration * 0.4).epsilon(1e-3));
  CHECK(simulation.actuator_effort(gear) == Approx(I_far * ratio * acceleration).epsilon(1e-2));
  CHECK(std::fabs(simulation.actuator_power(gear)) < 1e-4);  // passes power on, makes none
}

TEST_CASE("a span is a spring, a rope") {
  Scene scene;
  const BodyId bob = scene.add_rigid(wheel(0.01, {0, 0, -0.5}));
  const JointId span = scene.add_joint(
      {.definition = find_joint("span"), .a = world_frame({0, 0, 0}), .b = body_frame(bob, {})});
  const ActuatorId spring =
      add(scene, "spring_damper", span, {{"stiffness", 100.0}, {"rest", 0.4}, {"damping", 10}});
  const ActuatorId rope = add(scene, "upper_limit", span, {{"upper", 0.6}});
  Settings settings = machine_settings(0.01, 1e-6);
  settings.gravity = {0, 0, -9.81};
  Simulation simulation(scene, settings);
  for (int n = 0; n < 400; ++n) step(simulation);
  CHECK(simulation.joint_coordinates(span)[0] == Approx(0.4 + 9.81 / 100.0).epsilon(1e-6));
  CHECK(simulation.actuator_effort(spring) == Approx(-9.81).epsilon(1e-6));
  simulation.set_actuator_enabled(spring, false);
  for (int n = 0; n < 400; ++n) {
    step(simulation);
    CHECK(simulation.joint_coordinates(span)[0] <= 0.6 + 1e-6);
  }
  CHECK(simulation.actuator_effort(rope) == Approx(-9.81).epsilon(1e-6));
}

TEST_CASE("a cone keeps the axis of a ball joint") {
  Scene scene;
  const BodyId bob = scene.add_rigid(wheel(0.01, {0, 0, 1}));
  const FrameDescription a = world_frame({0, 0, 0}), b = body_frame(bob, {0, 0, -1});
  scene.add_joint({.definition = find_joint("ball"), .a = a, .b = b});
  const JointId tilt = scene.add_joint({.definition = find_joint("tilt"), .a = a, .b = b});
  const ActuatorId cone = add(scene, "upper_limit", tilt, {{"upper", 0.5}});
  Settings settings = machine_settings(0.01, 1e-6);
  settings.gravity = {0.3, 0.2, -9.81};
  Simulation simulation(scene, settings);
  for (int n = 0; n < 400; ++n) {
    step(simulation);
    CHECK(simulation.joint_coordinates(tilt)[0] <= 0.5 + 1e-5);
  }
  CHECK(simulation.joint_coordinates(tilt)[0] == Approx(0.5).epsilon(1e-4));
  CHECK(simulation.actuator_effort(cone) < -3.0);
}

TEST_CASE("a state goes on with the same bits, actuators and their values included") {
  const auto make = [] {
    Machine m = machine("hinge", wheel(0.01));
    add(m.scene, "position_servo", m.joint,
        {{"target", 1}, {"stiffness", 2}, {"damping", 0.1}, {"integral", 3}, {"cap", 0.5}});
    add(m.scene, "armature", m.joint, {{"inertia", 0.02}});
    add(m.scene, "limit", m.joint, {{"lower", -1}, {"upper", 0.4}});
    return m.scene;
  };
  Simulation first(make(), machine_settings(0.01));
  for (int n = 0; n < 10; ++n) step(first);
  first.set_actuator_value({0}, "target", -2.0);
  for (int n = 0; n < 3; ++n) step(first);
  Simulation second(make(), machine_settings(0.01));
  second.set_state(first.state());
  CHECK(second.actuator_value({0}, "target") == -2.0);
  CHECK(second.actuator_effort({0}) == first.actuator_effort({0}));
  for (int n = 0; n < 20; ++n) {
    step(first);
    step(second);
    CHECK(first_difference(first.state(), second.state()) == "");
  }
}

TEST_CASE("actuators keep the second order of BDF2") {
  const auto end = [](const std::string& kind, double h) {
    RigidDescription body = wheel(0.02);
    (kind == "hinge" ? body.angular_velocity : body.velocity) = {0, 0, 1.0};
    Machine m = machine(kind, body);
    add(m.scene, "spring_damper", m.joint, {{"stiffness", 2.0}, {"rest", 0.1}, {"damping", 0.1}});
    add(m.scene, "armature", m.joint, {{"inertia", 0.3}});
    add(m.scene, "joint_friction", m.joint, {{"cap", 0.0}, {"stick_rate", 1.0}, {"viscous", 0.2}});
    Settings settings = machine_settings(h, 1e-7);
    settings.time.integrator = Integrator::Bdf2;
    Simulation simulation(m.scene, settings);
    while (simulation.time() < 0.8 - 1e-9) step(simulation);
    return simulation.joint_coordinates(m.joint)[0];
  };
  for (const std::string kind : {"slider", "hinge"}) {
    CAPTURE(kind);
    const double coarse = end(kind, 0.02), middle = end(kind, 0.01), fine = end(kind, 0.005);
    const double ratio = (coarse - middle) / (middle - fine);
    CHECK(ratio > 3.3);  // 4 for second order, 2 for first
    CHECK(ratio < 5.0);
  }
}

TEST_CASE("quasistatic equilibria: servos hold, motors are refused") {
  Machine m = machine("slider", wheel(1.0));
  add(m.scene, "position_servo", m.joint, {{"target", 0.1}, {"stiffness", 100}, {"damping", 5}, {"cap", 50}});
  Settings settings = machine_settings(0.01);
  settings.time.integrator = Integrator::Quasistatic;
  settings.newton.acceleration_tolerance = 0.0;
  settings.newton.residual_tolerance = 1e-9;
  settings.gravity = {0, 0, -9.81};
  Simulation simulation(m.scene, settings);
  for (int n = 0; n < 3; ++n) step(simulation);
  CHECK(simulation.joint_coordinates(m.joint)[0] == Approx(0.1 - 0.0981).epsilon(1e-9));
  add(m.scene, "velocity_motor", m.joint, {{"target", 1}, {"cap", 1}, {"delta", 1}});
  CHECK_THROWS_WITH_AS(Simulation(m.scene, settings), doctest::Contains("quasistatic steps have none"),
                       InvalidArgument);
}

TEST_CASE("values that cannot be are refused, stops that are passed already too") {
  Machine m = machine("hinge", wheel(0.01));
  const ActuatorId motor = add(m.scene, "velocity_motor", m.joint, {{"target", 1}, {"cap", 1}, {"delta", 1}});
  const ActuatorId stop = add(m.scene, "upper_limit", m.joint, {{"upper", 1.0}});
  Simulation simulation(m.scene, machine_settings(0.01));
  CHECK_THROWS_WITH_AS(simulation.set_actuator_value(motor, "cap", -1.0),
                       doctest::Contains("actuator 'velocity_motor': cap = -1 N m"), InvalidArgument);
  CHECK_THROWS_WITH_AS(simulation.set_actuator_value(motor, "targt", 1.0), doctest::Contains("target"),
                       InvalidArgument);
  CHECK_THROWS_AS(simulation.set_actuator_value(motor, "target", NAN), InvalidArgument);
  CHECK_THROWS_AS(simulation.actuator_effort({7}), InvalidArgument);
  CHECK(simulation.actuator_value(stop, "upper") == 1.0);
  add(m.scene, "lower_limit", m.joint, {{"lower", 0.2}});
  CHECK_THROWS_WITH_AS(Simulation(m.scene, machine_settings(0.01)),
                       doctest::Contains("off by 0.2 rad at time 0"), InvalidArgument);
}
