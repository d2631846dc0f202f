// Physics of the user's own in a program outside the tree: an energy and a joint, each against a closed form.
// Returns 0 when both are right.
#include <cmath>
#include <iostream>
#include <memory>
#include <numbers>

#include <stark/stark.h>

namespace {

using namespace stark;

/// Spring to a fixed centre.
PotentialDefinition tether() {
  PotentialDefinition definition =
      define_potential("tether", 1, "spring to a centre", [](PotentialBuilder& b) {
        const symbolic::Vec3 d = b.x(0) - b.parameter3("centre", "m", "where it pulls to");
        return 0.5 * b.parameter("stiffness", "N/m", "stiffness") * symbolic::dot(d, d);
      });
  definition.translation_invariant = false;
  return definition;
}

/// The body slides along the z axis of frame a and does not turn.
JointDefinition slot() {
  return define_joint("slot", "translation along the z axis of a", [](JointBuilder& j) {
    const symbolic::Vec3 d = j.b.origin - j.a.origin;
    j.hold(symbolic::dot(j.a.x, d), ResidualUnit::Length);
    j.hold(symbolic::dot(j.a.y, d), ResidualUnit::Length);
    j.hold(j.a.x - j.b.x, ResidualUnit::Angle);
    j.hold(j.a.z - j.b.z, ResidualUnit::Angle);
    j.coordinate("displacement", symbolic::dot(j.a.z, d), "m");
  });
}

RigidDescription box(const char* name, const Vec3& position) {
  return {.name = name, .mesh = make_box({0.1, 0.1, 0.1}), .mass = 2.0, .position = position};
}

/// Whether |value - exact| <= tolerance; says so where it is not.
bool agrees(const char* what, double value, double exact, double tolerance) {
  if (std::fabs(value - exact) <= tolerance) return true;
  std::cerr << what << ": " << value << ", must be " << exact << '\n';
  return false;
}

}  // namespace

int main() {
  constexpr double kStep = 0.01, kStiffness = 50.0, kMass = 2.0, kGravity = 9.81;
  constexpr double kSlope = std::numbers::pi / 6.0;
  Scene scene;
  const BodyId swinging = scene.add_rigid(box("swinging", {1.0, 0.0, 0.0}));
  const EnergyId energy =
      scene.add_energy({.potential = tether(),
                        .points = {body_points(swinging, {{0.0, 0.0, 0.0}})},
                        .values = {{"stiffness", {{kStiffness}}}, {"centre", {{0.0, 0.0, 0.0}}}}});
  const BodyId sliding = scene.add_rigid(box("sliding", {0.0, 5.0, 0.0}));
  // The slot points down the slope: its z axis is the world's x axis, turned by 30 degrees about y.
  const Mat3 down = exp_rotation({0.0, 0.5 * std::numbers::pi + kSlope, 0.0});
  const JointId joint = scene.add_joint({.definition = std::make_shared<const JointDefinition>(slot()),
                                         .a = world_frame({0.0, 5.0, 0.0}, down),
                                         .b = body_frame(sliding, {0.0, 0.0, 0.0}, down)});
  Settings settings;
  settings.time.step = kStep;
  settings.gravity = {0.0, 0.0, -kGravity};
  settings.newton.step_tolerance = 1e-12;
  Simulation simulation(scene, settings);

  // Implicit Euler: v' = (v - h k x / m) / (1 + h^2 k / m), and v' = v + h g without a spring.
  double x = 1.0, v = 0.0, z = 0.0, w = 0.0;
  const double softening = 1.0 + kStep * kStep * kStiffness / kMass;
  constexpr int kSteps = 50;
  for (int n = 0; n < kSteps; ++n) {
    const StepReport& report = simulation.step();
    if (report.failed()) {
      std::cerr << report.message << '\n';
      return 1;
    }
    v = (v - kStep * kStiffness / kMass * x) / softening;
    w = (w - kStep * kGravity - kStep * kStiffness / kMass * z) / softening;
    x += kStep * v;
    z += kStep * w;
  }
  // The spring is solved to rounding; the joint to its tolerance of 1e-6 m.
  const double slid = kGravity * std::sin(kSlope) * kStep * kStep * 0.5 * kSteps * (kSteps + 1);
  const bool good = agrees("position", simulation.position(swinging).x, x, 1e-9) &&
                    agrees("height", simulation.position(swinging).z, z, 1e-9) &&
                    agrees("force", simulation.element_forces(energy)[0].x, -kStiffness * x, 1e-7) &&
                    agrees("displacement", simulation.joint_coordinates(joint)[0], slid, 1e-6) &&
                    agrees("normal force", norm(simulation.joint_reaction(joint).force),
                           kMass * kGravity * std::cos(kSlope), 1e-4);
  return good ? 0 : 2;
}
