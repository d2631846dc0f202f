// Layers of a model: unknowns, masses and damping of points, motion, bits, what contact sees.
#include <algorithm>

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include <stark/geometry/shapes.h>
#include <stark/sim/simulation.h>
#include <support/layer_scenes.h>
#include <support/simulation_checks.h>

using namespace stark;
using namespace stark::test;
using doctest::Approx;

namespace {

Settings quiet(double h = 0.01) {
  Settings settings;
  settings.time.step = h;
  settings.contact.enabled = false;
  return settings;
}

/// Rounding of the membrane's energy, of terms of E h A = 0.8 J that cancel [J].
constexpr double kRounding = 1e-15;

/// Cloth of 5 x 5 vertices with a skin, a straight fibre, a ring and a cord that only stretches.
Scene composite(ClothDescription sheet = {}) {
  sheet.name = "sheet";
  sheet.mesh = make_grid(0.4, 0.4, 4, 4);
  sheet.material.strain_limit = std::numeric_limits<double>::infinity();
  Scene scene;
  const BodyId body = scene.add_cloth(sheet);
  const RodMaterial cord{.density = 1100.0, .youngs_modulus = 1e6, .radius = 2e-3};
  scene.add_skin({.body = body, .triangles = {sheet.mesh.triangles[0], sheet.mesh.triangles[1]}});
  scene.add_fibres({.body = body, .paths = {{10, 11, 12, 13, 14}}, .material = cord});
  scene.add_fibres({.body = body, .paths = {{6, 7, 8, 13, 18, 17, 16, 11, 6}}, .material = cord});
  scene.add_fibres({.body = body, .paths = {{0, 5, 10, 15}}, .material = cord, .bending = false});
  return scene;
}

}  // namespace

TEST_CASE("skins and stretching cords have no unknowns, nodes that bend turn with three") {
  const Simulation sim(composite(), quiet());
  const DofLayout& layout = sim.model().map().layout();
  CHECK(layout.point_block.size() == 25);
  REQUIRE(layout.body_block.size() == 5 + 8);
  for (size_t b = 0; b < 13; ++b) {
    CHECK(layout.body_block[b] == kNoBlock);
    CHECK(layout.rotation_block[b] != kNoBlock);
  }
  CHECK(layout.block_count == 25 + 13);
  CHECK(sim.frames(FibresId{0}).size() == 5);
  CHECK(sim.frames(FibresId{1}).size() == 8);
  CHECK(sim.frames(FibresId{2}).empty());
  CHECK_THROWS_AS(sim.frames(FibresId{3}), std::exception);
}

TEST_CASE("forces of mass damping add up") {
  ClothDescription sheet;
  sheet.mesh = make_grid(1, 1, 1, 1);
  sheet.material = {.density = 1.0, .mass_damping = 0.5};
  Scene scene;
  const BodyId body = scene.add_cloth(sheet);
  scene.add_skin({.body = body, .material = {.density = 3.0, .mass_damping = 2.0}});
  Settings settings = quiet(0.1);
  settings.gravity = {};
  const Simulation sim(scene, settings);
  const PotentialBatch* inertia = nullptr;
  for (const ModelBatch& batch : sim.energies().batches)
    if (batch.role == ModelBatch::Role::Inertia) inertia = &batch.batch;
  REQUIRE(inertia != nullptr);
  const double expected = (1.0 * 0.5 + 3.0 * 2.0) / 4.0;
  CHECK(inertia->get(inertia->field_index("damping"), 0) == Approx(expected));
}

TEST_CASE("nothing moves at rest") {
  Settings settings = quiet();
  settings.gravity = {};
  Simulation sim(composite(), settings);
  const std::vector<Vec3> start = sim.positions({0});
  for (int k = 0; k < 3; ++k) REQUIRE_FALSE(sim.step().failed());
  for (size_t v = 0; v < start.size(); ++v) CHECK(norm(sim.positions({0})[v] - start[v]) < 1e-12);
  CHECK(sim.report().energy.elastic < kRounding);
}

TEST_CASE("a free composite falls as a point does, and its momentum is that of its mass") {
  ClothDescription sheet;
  sheet.velocity = {0.3, -0.2, 1.0};
  sheet.material.mass_damping = 0.0;
  const Scene scene = composite(sheet);
  Simulation sim(scene, quiet());
  double mass = 0.0;
  for (const double m : sim.model().point_masses()) mass += m;
  for (int k = 1; k <= 10; ++k) {
    REQUIRE_FALSE(sim.step().failed());
    const Vec3 velocity = sheet.velocity + sim.settings().gravity * (0.01 * k);
    CHECK(norm(sim.report().momentum.linear - velocity * mass) < 1e-9 * mass);
  }
  CHECK(sim.report().energy.elastic < kRounding);
}

TEST_CASE("a turning composite keeps its angular momentum") {
  ClothDescription sheet;
  sheet.angular_velocity = {1.0, 2.0, 3.0};
  sheet.material.mass_damping = 0.0;
  const Scene scene = composite(sheet);
  Settings settings = quiet(0.002);
  settings.gravity = {};
  settings.newton.acceleration_tolerance = 1e-8;
  Simulation sim(scene, settings);
  REQUIRE_FALSE(sim.step().failed());
  const Vec3 L = sim.report().momentum.angular;
  while (sim.time() < 0.099) REQUIRE_FALSE(sim.step().failed());
  CHECK(norm(sim.report().momentum.angular - L) < 1e-12 * norm(L));
}

TEST_CASE("a fibre of a straight rest shape flattens the fold that its sheet is at rest in") {
  const auto deviation = [](RestShape shape, bool bending) {
    ClothDescription sheet{.mesh = make_grid(0.4, 0.1, 4, 1), .rest_angles = RestAngles::Mesh};
    for (Vec3& v : sheet.mesh.vertices) v.z = 0.5 * v.x * v.x;
    Scene scene;
    const BodyId body = scene.add_cloth(sheet);
    FibresDescription fibres{.body = body, .paths = {{0, 1, 2, 3, 4}}, .bending = bending};
    fibres.material = {.youngs_modulus = 1e8, .radius = 2e-3};
    fibres.rest_shape = shape;
    scene.add_fibres(fibres);
    Settings settings = quiet();
    settings.gravity = {};
    settings.time.integrator = Integrator::Quasistatic;
    scene.pin(body, std::vector<int32_t>{0, 1, 5, 6});
    Simulation sim(scene, settings);
    REQUIRE_FALSE(sim.step().failed());
    const auto x = sim.positions(body);
    return norm(cross(x[4] - x[0], normalized(x[1] - x[0])));  // of the tip from the first edge's line
  };
  const double curved = deviation(RestShape::Mesh, true);
  CHECK(curved == Approx(0.06 / std::sqrt(1.0 + 0.15 * 0.15)).epsilon(1e-6));
  CHECK(deviation(RestShape::Mesh, false) == Approx(curved).epsilon(1e-6));
  CHECK(deviation(RestShape::Straight, true) < 0.1 * curved);
}

TEST_CASE("contact sees the surface of the body and nothing of its layers") {
  Scene plain;
  const BodyId sheet = plain.add_cloth({.mesh = make_grid(0.4, 0.4, 4, 4)});
  const Simulation without(plain, Settings{});
  plain.add_fibres({.body = sheet, .paths = {{0, 6, 12}}});
  plain.add_skin({.body = sheet});
  const Simulation with(plain, Settings{});
  CHECK(with.surface_mesh().edges == without.surface_mesh().edges);
  CHECK(with.surface_mesh().triangles == without.surface_mesh().triangles);
}

TEST_CASE("a layer is a part of the scene that a state belongs to") {
  Scene scene;
  add_block(scene);
  const size_t plain = Simulation(scene, quiet()).model().parts().size();
  scene.add_skin({.name = "coat", .body = {0}});
  const auto parts = Simulation(scene, quiet()).model().parts();
  CHECK(parts.size() > plain);
  CHECK(std::ranges::any_of(
      parts, [](const ModelPart& part) { return part.name.find("coat") != std::string::npos; }));
}

TEST_CASE("the same bits from any number of threads, and after going back to a state") {
  const auto end = [](int threads, bool rewind) {
    Scene scene = composite();
    scene.pin({0}, std::vector<int32_t>{0, 4});
    Settings settings = quiet();
    settings.contact.enabled = true;
    settings.execution.threads = threads;
    settings.execution.oversubscribe = true;
    Simulation sim(scene, settings);
    for (int k = 0; k < 10; ++k) REQUIRE_FALSE(sim.step().failed());
    const State state = sim.state();
    for (int k = 0; k < 10; ++k) REQUIRE_FALSE(sim.step().failed());
    if (!rewind) return sim.state().hash();
    Simulation resumed(scene, settings);
    resumed.set_state(state);
    for (int k = 0; k < 10; ++k) REQUIRE_FALSE(resumed.step().failed());
    return resumed.state().hash();
  };
  const auto once = end(1, false);
  CHECK(end(2, false) == once);
  CHECK(end(3, false) == once);
  CHECK(end(1, true) == once);
}
