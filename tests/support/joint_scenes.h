// Small machines for tests of actuators: a wheel on a hinge, a carriage on a slider.
#pragma once

#include <cmath>

#include <stark/stark.h>

namespace stark::test {

inline Settings machine_settings(double h, double acceleration_tolerance = 1e-10) {
  Settings settings;
  settings.time.step = h;
  settings.contact.enabled = false;
  settings.gravity = {};
  // Closed forms are compared to nine digits, so equilibria have to be exact. Stiff stops end earlier in
  // rounding.
  settings.newton.acceleration_tolerance = acceleration_tolerance;
  return settings;
}

/// Body of 1 kg whose moments of inertia are all `inertia` [kg m^2].
inline RigidDescription wheel(double inertia, const Vec3& position = {}, double mass = 1.0) {
  RigidInertia given{
      .mass = mass, .center_of_mass = {}, .tensor = Mat3::diagonal({inertia, inertia, inertia})};
  return {.mesh = make_box({0.1, 0.1, 0.1}), .inertia = given, .position = position};
}

/// A body on a hinge or slider along the world's z axis.
struct Machine {
  Scene scene;
  BodyId body{};
  JointId joint{};
};

inline Machine machine(const std::string& kind, const RigidDescription& body) {
  Machine m;
  m.body = m.scene.add_rigid(body);
  m.joint = m.scene.add_joint(
      {.definition = find_joint(kind), .a = world_frame(body.position), .b = body_frame(m.body, {})});
  return m;
}

inline ActuatorId add(Scene& scene, const std::string& kind, JointId joint,
                      std::map<std::string, double> values) {
  return scene.add_actuator(
      {.definition = find_actuator(kind), .on = {{joint}}, .values = std::move(values)});
}

}  // namespace stark::test
