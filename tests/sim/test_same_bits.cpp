// Whole scenes have the same bits on every processor: the hashes below are those of x86-64;
// tools/aarch64.sh runs this under emulation. A change of the numerics changes them on all processors alike.
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
  CHECK(sim.state().hash() == 0xf279c4c5cb183489u);
}

TEST_CASE("cloth, solid, rod and rigid bodies in contact have the same bits everywhere") {
  Scene scene;
  scene.set_default_friction(0.5);
  scene.add_rigid({.name = "sphere",
                   .mesh = make_icosphere(0.1, 1),
                   .motion = Motion::Fixed,
                   .position = {0.01, 0.02, -0.105}});
  scene.add_cloth({.name = "cloth", .mesh = make_grid(0.4, 0.4, 8, 8), .material = materials::cotton()});
  scene.add_rigid({.name = "box",
                   .mesh = make_box({0.04, 0.05, 0.06}),
                   .mass = 0.02,
                   .position = {0.03, 0.0, 0.04},
                   .velocity = {0, 0, -1},
                   .angular_velocity = {1, 2, 3}});
  scene.add_solid({.name = "soft",
                   .mesh = make_tet_box({0.04, 0.04, 0.04}, {1, 1, 1}),
                   .material = materials::soft_rubber(),
                   .position = {-0.04, 0.01, 0.03},
                   .velocity = {0, 0, -1}});
  RodDescription rod{.name = "rod", .position = {0.0, 0.0, 0.1}};
  for (int k = 0; k <= 8; ++k) rod.mesh.vertices.push_back({0.02 * (k - 4), 0.01, 0.0});
  scene.add_rod(std::move(rod));
  Settings settings;
  settings.time.step = 0.01;
  settings.contact.distance = 2e-3;
  Simulation sim(scene, settings);
  for (int k = 0; k < 30; ++k) REQUIRE_FALSE(sim.step().failed());
  CHECK(sim.state().hash() == 0x1854af82ede96b00u);
}
