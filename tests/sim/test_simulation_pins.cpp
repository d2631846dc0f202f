// Prescribed vertices and frames: targets are reached at the end of the next step, wrong ones refused.
#include <doctest/doctest.h>

#include <limits>

#include <stark/base/error.h>
#include <stark/base/rotation.h>
#include <stark/geometry/shapes.h>
#include <stark/sim/simulation.h>
#include <support/model_checks.h>

using namespace stark;

namespace {

Scene rod_scene(BodyId& rod) {
  RodDescription description;
  description.material = {.density = 1000.0, .youngs_modulus = 1e7, .radius = 0.01};
  for (int i = 0; i <= 4; ++i) description.mesh.vertices.push_back({0.25 * i, 0, 0});
  Scene scene;
  rod = scene.add_rod(description);
  scene.clamp(rod, std::vector<int32_t>{0});
  scene.pin(rod, std::vector<int32_t>{4});
  return scene;
}

Settings quiet() {
  Settings settings;
  settings.time.step = 0.01;
  settings.contact.enabled = false;
  return settings;
}

}  // namespace

TEST_CASE("pinned and clamped nodes reach their targets in one step and then rest") {
  BodyId rod;
  const Scene scene = rod_scene(rod);
  Simulation sim(scene, quiet());
  const Mat3 turn = exp_rotation({0.1, 0.05, 0.0}) * sim.frames(rod)[0];
  const std::vector<Vec3> targets{{0.0, 0.01, 0.0}, {1.0, 0.0, 0.02}};
  sim.set_pin_targets(rod, targets);
  sim.set_clamp_targets(rod, std::vector<Mat3>{turn});
  CHECK(sim.pin_targets(rod) == targets);
  CHECK(sim.clamp_targets(rod).size() == 1);
  for (int k = 0; k < 3; ++k) {
    REQUIRE_FALSE(sim.step().failed());
    CHECK(sim.positions(rod)[0] == targets[0]);
    CHECK(sim.positions(rod)[4] == targets[1]);
    CHECK(test::squared_frobenius(sim.frames(rod)[0] - turn) < 1e-28);
    if (k == 0) CHECK(norm(sim.velocities(rod)[4] - Vec3{0, 0, 2}) < 1e-10);
    if (k > 0) CHECK(norm(sim.velocities(rod)[4]) == 0.0);
  }
}

TEST_CASE("the frame at a pin stays free, and follows") {
  BodyId rod;
  const Scene scene = rod_scene(rod);
  Simulation sim(scene, quiet());
  sim.set_pin_targets(rod, std::vector<Vec3>{{0, 0, 0}, {1.0, 0.0, 0.1}});
  for (int k = 0; k < 50; ++k) REQUIRE_FALSE(sim.step().failed());
  CHECK(sim.frames(rod)[4].column(2).z > 0.1);
  CHECK(max_abs(sim.frames(rod)[0].column(2) - Vec3{1, 0, 0}) == 0.0);
}

TEST_CASE("pins of cloth follow targets as before") {
  Scene scene;
  const BodyId cloth = scene.add_cloth({.mesh = make_grid(0.4, 0.4, 2, 2)});
  scene.pin(cloth, std::vector<int32_t>{2, 0});
  Simulation sim(scene, quiet());
  const std::vector<Vec3> targets{{0.3, 0.2, 0.1}, {-0.3, -0.2, 0.1}};
  sim.set_pin_targets(cloth, targets);
  REQUIRE_FALSE(sim.step().failed());
  CHECK(sim.positions(cloth)[2] == targets[0]);
  CHECK(sim.positions(cloth)[0] == targets[1]);
}

TEST_CASE("targets of the wrong number, not finite or no rotations are refused") {
  BodyId rod;
  const Scene scene = rod_scene(rod);
  Simulation sim(scene, quiet());
  CHECK_THROWS_AS(sim.set_pin_targets(rod, std::vector<Vec3>(1)), InvalidArgument);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(sim.set_pin_targets(rod, std::vector<Vec3>{{0, 0, 0}, {nan, 0, 0}}), InvalidArgument);
  CHECK_THROWS_AS(sim.set_clamp_targets(rod, std::vector<Mat3>(2, Mat3::identity())), InvalidArgument);
  CHECK_THROWS_AS(sim.set_clamp_targets(rod, std::vector<Mat3>{Mat3::diagonal({1, 1, -1})}), InvalidArgument);
  const BodyId none{7};
  CHECK_THROWS_AS(sim.frames(none), InvalidArgument);
}
