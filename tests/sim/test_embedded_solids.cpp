// Solids whose surface is embedded in a lattice: what follows, momentum of forces on the surface, refusals.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <span>

#include <stark/geometry/embedding.h>
#include <stark/stark.h>

using namespace stark;
using doctest::Approx;

namespace {

Settings without_gravity() {
  Settings settings;
  settings.time.step = 0.01;
  settings.gravity = {};
  settings.newton.step_tolerance = 1e-12;
  return settings;
}

SolidDescription ball(bool quadratic = false) {
  SolidDescription solid{.mesh = make_lattice(make_icosphere(0.1, 2), 0.05, quadratic),
                         .material = materials::soft_rubber()};
  solid.material.mass_damping = 0.0;
  return solid;
}

/// Force f on one point: -f x.
PotentialDefinition pull() {
  PotentialDefinition definition = define_potential("pull", 1, "constant force", [](PotentialBuilder& b) {
    return symbolic::Scalar(-1.0) * symbolic::dot(b.parameter3("force", "N", "force"), b.x(0));
  });
  definition.translation_invariant = false;
  return definition;
}

}  // namespace

TEST_CASE("embedded vertices are where the shape functions of their cells put them, after every step") {
  for (const bool quadratic : {false, true}) {
    Scene scene;
    SolidDescription description = ball(quadratic);
    description.angular_velocity = {0.0, 20.0, 5.0};
    const SolidMesh mesh = description.mesh;
    const BodyId body = scene.add_solid(description);
    Simulation simulation(scene, without_gravity());
    for (int k = 0; k < 5; ++k) REQUIRE_FALSE(simulation.step().failed());
    const std::vector<Vec3> x = simulation.positions(body), v = simulation.velocities(body);
    std::vector<double> weights(mesh.node_count());
    const std::vector<double> all_weights = embedding_weights(mesh);
    for (size_t k = 0; k < mesh.embedding.elements.size(); ++k) {
      embedding_weights(mesh, k, weights);
      CHECK(std::ranges::equal(weights, std::span(all_weights).subspan(k * weights.size(), weights.size())));
      Vec3 at, speed;
      for (int a = 0; a < mesh.node_count(); ++a) {
        at += x[mesh.element(mesh.embedding.elements[k])[a]] * weights[a];
        speed += v[mesh.element(mesh.embedding.elements[k])[a]] * weights[a];
      }
      CHECK(norm(x[mesh.first_embedded() + k] - at) < 1e-14);
      CHECK(norm(v[mesh.first_embedded() + k] - speed) < 1e-11);
    }
    CHECK(simulation.triangles(body) == mesh.embedding.triangles);
  }
}

TEST_CASE("a force on a vertex of the surface, and on a point between some, moves the body by its impulse") {
  for (const bool between : {false, true}) {
    Scene scene;
    const SolidDescription description = ball();
    const Index3 t = description.mesh.embedding.triangles[7];
    const BodyId body = scene.add_solid(description);
    scene.add_energy(
        {.potential = pull(),
         .points = {between ? embedded_points(body, {{t[0], t[1], t[2], 0}}, {{0.2, 0.3, 0.5, 0.0}})
                            : vertex_points(body, {t[0]})},
         .values = {{"force", {{0.1, 0.2, 0.3}}}}});
    Simulation simulation(scene, without_gravity());
    Momentum momentum;
    for (int k = 0; k < 10; ++k) {
      const StepReport& report = simulation.step();
      REQUIRE_FALSE(report.failed());
      momentum = report.momentum;
    }
    CHECK(norm(momentum.linear - Vec3{0.01, 0.02, 0.03}) < 1e-6);
    const Vec3 x = between ? Vec3{} : simulation.positions(body)[t[0]];
    if (!between) CHECK(norm(momentum.angular - cross(x, momentum.linear)) < 0.05 * norm(momentum.angular));
  }
}

TEST_CASE("embedded vertices cannot be pinned nor carry layers, and wrong embeddings are refused") {
  Scene scene;
  const SolidDescription good = ball();
  const BodyId body = scene.add_solid(good);
  const int32_t last[] = {static_cast<int32_t>(good.mesh.vertices.size()) - 1};
  CHECK_THROWS_WITH_AS(scene.pin(body, last), doctest::Contains("is embedded"), InvalidArgument);
  CHECK_THROWS_WITH_AS(scene.add_skin({.body = body, .material = materials::cotton()}),
                       doctest::Contains("embedded"), InvalidArgument);
  const auto refused = [&](auto&& change) {
    SolidDescription wrong = good;
    change(wrong.mesh);
    CHECK_THROWS_AS(scene.add_solid(wrong), InvalidMesh);
  };
  refused([](SolidMesh& mesh) { mesh.embedding.fillings.pop_back(); });
  refused([](SolidMesh& mesh) { mesh.embedding.fillings[0].moments = {}; });
  refused([](SolidMesh& mesh) { mesh.embedding.elements[0] = -1; });
  refused([](SolidMesh& mesh) { mesh.embedding.triangles[0] = {0, 1, 2}; });
  refused([](SolidMesh& mesh) { mesh.embedding.triangles.pop_back(), mesh.vertices.back().x += 1.0; });
  refused([](SolidMesh& mesh) { mesh.embedding.elements.push_back(0), mesh.vertices.push_back({}); });
  CHECK(scene.body_count() == 1);
}
