// A program that knows nothing but the installed package: a cloth falls onto a turning box. Returns 0 when
// the library answers correctly.
#include <cmath>
#include <iostream>

#include <stark/stark.h>

int main() {
  stark::Scene scene;
  const stark::BodyId cloth = scene.add_cloth(
      {.name = "cloth", .mesh = stark::make_grid(0.4, 0.4, 8, 8), .material = stark::materials::cotton()});
  const stark::BodyId box = scene.add_rigid({.name = "box",
                                             .mesh = stark::make_box({0.08, 0.08, 0.08}),
                                             .motion = stark::Motion::Scripted,
                                             .position = {0.0, 0.0, -0.08},
                                             .angular_velocity = {0.0, 0.0, 1.5}});
  stark::Settings settings;
  settings.contact.distance = 0.0025;
  stark::Simulation simulation(scene, settings);
  while (simulation.time() < 0.1) {
    const stark::StepReport& report = simulation.step();
    if (report.failed()) {
      std::cerr << report.message << '\n';
      return 1;
    }
  }
  bool fell = false;
  for (const stark::Vec3& x : simulation.positions(cloth)) {
    if (!stark::is_finite(x)) return 2;
    fell = fell || x.z < -1e-3;
  }
  // The box has turned by angular velocity times time about z.
  const double turned = std::atan2(simulation.rotation(box)(1, 0), simulation.rotation(box)(0, 0));
  if (std::fabs(turned - 1.5 * simulation.time()) > 1e-9) return 3;

  bool refused = false;
  try {
    scene.add_cloth({.name = "empty", .mesh = {}, .material = stark::materials::cotton()});
  } catch (const stark::InvalidArgument&) {
    refused = true;
  }
  return fell && refused ? 0 : 4;
}
