// A whole scene has the same bits on every processor: the hash below is that of the scene hello_cloth after a
// second on x86-64; tools/aarch64.sh runs this under emulation.
#include <numbers>

#include <doctest/doctest.h>
#include <stark/base/rotation.h>
#include <stark/geometry/shapes.h>
#include <stark/sim/simulation.h>

using namespace stark;

TEST_CASE("hello_cloth has the same bits after a second everywhere") {
  Scene scene;
  scene.set_default_friction(0.3);
  ShellMaterial material = materials::cotton();
  material.strain_limit_hardening = 0.0;
  scene.add_cloth({.name = "cloth", .mesh = make_grid(0.4, 0.4, 32, 32), .material = material});
  const BodyId box = scene.add_rigid({.name = "box",
                                      .mesh = make_box({0.08, 0.08, 0.08}),
                                      .motion = Motion::Scripted,
                                      .position = {0, 0, -0.08}});
  Settings settings;
  settings.time.step = 1.0 / 30.0;
  settings.contact.distance = 0.0025;
  Simulation sim(scene, settings);
  for (int k = 0; k < 30; ++k) {
    const double angle = 0.5 * std::numbers::pi * (sim.time() + settings.time.step);
    sim.set_pose(box, {0, 0, -0.08}, exp_rotation({0, 0, angle}));
    REQUIRE_FALSE(sim.step().failed());
  }
  CHECK(sim.state().hash() == 0xe56c3e6d37111aecu);
}
