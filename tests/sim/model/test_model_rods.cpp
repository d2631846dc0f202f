// Rods of a model: masses, unknowns of pinned and clamped nodes, rest shapes, contact surfaces, momentum.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include <stark/base/rotation.h>
#include <stark/geometry/shapes.h>
#include <stark/sim/simulation.h>
#include <support/simulation_checks.h>

using namespace stark;
using namespace stark::test;
using doctest::Approx;

namespace {

RodDescription straight(int segments = 4, double length = 1.0) {
  RodDescription rod;
  rod.material = {.density = 1000.0, .youngs_modulus = 1e7, .radius = 0.01};
  for (int i = 0; i <= segments; ++i) rod.mesh.vertices.push_back({length * i / segments, 0, 0});
  return rod;
}

Settings quiet(double h = 0.01) {
  Settings settings;
  settings.time.step = h;
  settings.contact.enabled = false;
  return settings;
}

/// Angular momentum of all nodes about the origin [kg m^2/s].
Vec3 angular_momentum(const Simulation& sim) {
  Vec3 L;
  for (size_t b = 0; b < sim.model().rigid_masses().size(); ++b)
    L += spin(sim, static_cast<int>(b)) + cross(sim.state().body_position[b], sim.state().body_velocity[b]) *
                                              sim.model().rigid_masses()[b].mass;
  return L;
}

}  // namespace

TEST_CASE("nodes carry half the mass and the moments of the section of their segments") {
  Scene scene;
  scene.add_rod(straight());
  const Simulation sim(scene, quiet());
  const auto& nodes = sim.model().rigid_masses();
  REQUIRE(nodes.size() == 5);
  const double area = std::numbers::pi * 1e-4, segment = 1000.0 * area * 0.25;
  CHECK(nodes[0].mass == Approx(0.5 * segment));
  CHECK(nodes[2].mass == Approx(segment));
  const double moment = segment * 0.25 * 1e-4;  // rho A L r^2/4
  CHECK(nodes[2].moments.x == Approx(moment));
  CHECK(nodes[2].moments.y == Approx(moment));
  CHECK(nodes[2].moments.z == Approx(2.0 * moment));
}

TEST_CASE("densities differ by segment") {
  Scene scene;
  RodDescription rod = straight(2);
  rod.fields["density"] = {{1000.0, 3000.0}, true};
  scene.add_rod(rod);
  const Simulation sim(scene, quiet());
  const auto& nodes = sim.model().rigid_masses();
  CHECK(nodes[1].mass == Approx(nodes[0].mass + nodes[2].mass));
  CHECK(nodes[2].mass == Approx(3.0 * nodes[0].mass));
}

TEST_CASE("a pinned node turns freely, a clamped one has no unknowns") {
  Scene scene;
  const BodyId rod = scene.add_rod(straight());
  scene.pin(rod, std::vector<int32_t>{1});
  scene.clamp(rod, std::vector<int32_t>{3});
  const Simulation sim(scene, quiet());
  const DofLayout& layout = sim.model().map().layout();
  CHECK(layout.body_block == std::vector<int32_t>{0, kNoBlock, 3, kNoBlock, 5});
  CHECK(layout.rotation_block == std::vector<int32_t>{1, 2, 4, kNoBlock, 6});
  CHECK(layout.block_count == 7);
}

TEST_CASE("a pinned rod swings about its end, which stays in place") {
  Scene scene;
  const BodyId rod = scene.add_rod(straight());
  scene.pin(rod, std::vector<int32_t>{0});
  Simulation sim(scene, quiet());
  for (int k = 0; k < 20; ++k) REQUIRE_FALSE(sim.step().failed());
  CHECK(sim.positions(rod)[0] == Vec3{0, 0, 0});
  CHECK(sim.positions(rod)[4].z < -0.1);
  CHECK(sim.frames(rod)[0].column(2).z < -0.1);  // the frame at the pin follows
}

TEST_CASE("a rod of bent rest shape stays as it is, one with a straight rest shape springs open") {
  for (const RestShape shape : {RestShape::Mesh, RestShape::Straight}) {
    RodDescription rod = straight();
    rod.rest_shape = shape;
    for (int i = 0; i < 5; ++i)
      rod.mesh.vertices[i] = {std::sin(0.3 * i), 1.0 - std::cos(0.3 * i), 0.02 * i * i};
    const std::vector<Vec3> start = rod.mesh.vertices;
    Scene scene;
    const BodyId id = scene.add_rod(rod);
    Settings settings = quiet();
    settings.gravity = {};
    Simulation sim(scene, settings);
    double motion = 0.0;
    for (int k = 0; k < 5; ++k) REQUIRE_FALSE(sim.step().failed());
    for (int i = 0; i < 5; ++i) motion = std::max(motion, norm(sim.positions(id)[i] - start[i]));
    if (shape == RestShape::Mesh) CHECK(motion < 1e-10);
    if (shape == RestShape::Straight) CHECK(motion > 1e-3);
  }
}

TEST_CASE(
    "a free rod keeps its momentum; its angular momentum changes while it springs open, with the step") {
  const auto drift = [](double h) {
    RodDescription rod = straight(8);
    rod.rest_shape = RestShape::Straight;
    for (int i = 0; i < 9; ++i)
      rod.mesh.vertices[i] = {0.5 * std::sin(0.2 * i), 0.5 - 0.5 * std::cos(0.2 * i), 0.0};
    rod.velocity = {0.3, -0.2, 0.1};
    rod.angular_velocity = {1.0, 2.0, 3.0};
    Scene scene;
    scene.add_rod(rod);
    Settings settings = quiet(h);
    settings.gravity = {};
    settings.newton.acceleration_tolerance = 1e-8;
    Simulation sim(scene, settings);
    const Vec3 p = linear_momentum(sim), L = angular_momentum(sim);
    while (sim.time() < 0.1 - 0.5 * h) REQUIRE_FALSE(sim.step().failed());
    CHECK(norm(linear_momentum(sim) - p) < 1e-9 * norm(p));
    return norm(angular_momentum(sim) - L) / norm(L);
  };
  // Implicit Euler: sum of h^2 v x f in a step, with elastic forces f; none of it in axes that turn along.
  const double coarse = drift(0.002), fine = drift(0.0005);
  CHECK(coarse < 0.002);
  CHECK(fine < 0.5 * coarse);
}

TEST_CASE("contact takes the edges of rods, at the distance of their thickness") {
  Scene scene;
  const BodyId round = scene.add_rod(straight());
  RodDescription flat = straight();
  flat.material.width = 0.02;
  flat.material.height = 0.004;
  flat.position = {0, 1, 0};
  const BodyId plate = scene.add_rod(flat);
  RodDescription own = straight();
  own.contact_distance = 5e-4;
  own.position = {0, 2, 0};
  const BodyId thin = scene.add_rod(own);
  CHECK(scene.contact_distance(round).value() == Approx(0.01));
  CHECK(scene.contact_distance(plate).value() == Approx(0.002));
  CHECK(scene.contact_distance(thin).value() == Approx(5e-4));
  const Simulation sim(scene, Settings{});
  CHECK(sim.surface_mesh().triangles.empty());
  CHECK(sim.surface_mesh().edges.size() == 12);
}

TEST_CASE("the same bits from any number of threads, and after going back to a state") {
  const auto end = [](int threads, bool rewind) {
    Scene scene;
    const BodyId rod = scene.add_rod(straight(16));
    scene.clamp(rod, std::vector<int32_t>{0});
    scene.add_rigid(
        {.mesh = make_box({0.2, 0.2, 0.2}), .motion = Motion::Fixed, .position = {0.5, 0, -0.15}});
    Settings settings;
    settings.time.step = 0.01;
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
  CHECK(end(1, true) == once);
}

TEST_CASE("nodes are kept from edges that start within half a turn of the tightest bend along the rod") {
  Scene scene;
  scene.add_rod(straight(100));  // segments of 10 mm; contact distance of a pair 20 mm, half a turn 31.4 mm
  const Simulation sim(scene, quiet());
  const PairFilter filter = sim.model().make_surfaces(scene, quiet()).filter;
  const int32_t first = sim.model().bodies()[0].first_site;
  const auto apart = [&](int32_t node, int32_t edge) {
    return !filter.are_neighbours(first + node, {first + edge, first + edge + 1});
  };
  for (const int32_t edge : {51, 52, 53, 48, 47, 46}) CHECK_FALSE(apart(50, edge));
  for (const int32_t edge : {54, 80, 45, 0}) CHECK(apart(50, edge));
}

TEST_CASE("parallel rods repel each other") {
  Scene scene;
  RodDescription rod = straight(3);
  scene.add_rod(rod);
  rod.position = {0.0, 1e-6, 0.025};
  rod.velocity = {0.0, 0.0, -1.0};
  const BodyId upper = scene.add_rod(rod);
  Settings settings;
  settings.gravity = {};
  settings.time.step = 1e-3;
  Simulation sim(scene, settings);
  double nearest = 1.0;
  for (int k = 0; k < 30; ++k) {
    const StepReport& report = sim.step();
    REQUIRE(report.status == StepStatus::Accepted);
    for (int32_t v = 0; v <= 3; ++v)
      nearest = std::min(nearest, norm(sim.positions(upper)[v] - sim.positions(BodyId{0})[v]));
  }
  CHECK(nearest < 0.02);
  CHECK(nearest > 0.01);
  CHECK(sim.velocities(upper)[1].z > -0.51);  // equal masses: at least half of the momentum is handed on
}
