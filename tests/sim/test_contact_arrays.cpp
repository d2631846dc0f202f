// Contacts as arrays: rows that agree with the positions of the vertices and with Newton's laws.
#include <doctest/doctest.h>

#include <algorithm>
#include <string>

#include <stark/geometry/shapes.h>
#include <stark/sim/contact_arrays.h>

using namespace stark;
using doctest::Approx;

namespace {

/// A box of 2 kg on a floor whose triangles have a middle vertex in a flat face, after it has come to rest.
struct RestingBox {
  static Scene scene() {
    Scene scene;
    scene.add_rigid({.name = "floor", .mesh = make_grid(1.0, 1.0, 2, 2), .motion = Motion::Fixed});
    scene.add_rigid(
        {.name = "box", .mesh = make_box({0.1, 0.1, 0.1}), .mass = 2.0, .position = {0.2, 0.2, 0.0508}});
    return scene;
  }
  RestingBox() {
    for (int n = 0; n < 60; ++n) REQUIRE_FALSE(sim.step().failed());
  }
  Simulation sim{scene()};
};

}  // namespace

TEST_CASE("rows of contacts carry the weight, between points that their weights give") {
  const RestingBox resting;
  const Simulation& sim = resting.sim;
  const ContactArrays rows = contact_arrays(sim);
  REQUIRE(rows.bodies.size() == sim.contacts().size());
  REQUIRE_FALSE(rows.bodies.empty());
  Vec3 on_box;
  for (size_t k = 0; k < rows.bodies.size(); ++k) {
    const auto [a, b] = rows.bodies[k];
    on_box += rows.normal_forces[k] * (a == 1 ? 1.0 : -1.0);
    Vec3 points[2];
    double shares[2] = {0.0, 0.0};
    for (int p = 0; p < 4 && rows.vertices[k][p] >= 0; ++p) {
      const int side = p < rows.first_counts[k] ? 0 : 1;
      const std::vector<Vec3> x = sim.positions({side == 0 ? a : b});
      const double weight = side == 0 ? rows.weights[k][p] : -rows.weights[k][p];
      points[side] += x.at(rows.vertices[k][p]) * weight;
      shares[side] += weight;
    }
    CHECK(shares[0] == Approx(1.0));
    CHECK(shares[1] == Approx(1.0));
    // Forces are those of the last iterate before the end: places differ by what it moved.
    CHECK(norm(points[0] - rows.points_a[k]) < 1e-6);
    CHECK(norm(points[1] - rows.points_b[k]) < 1e-6);
    CHECK(norm(rows.points_a[k] - rows.points_b[k]) == Approx(rows.distances[k]).epsilon(1e-6));
  }
  CHECK(on_box.z == Approx(2.0 * 9.81).epsilon(1e-3));
  for (const int32_t body : {0, 1}) {
    Vec3 sum;
    for (const Vec3& force : sim.vertex_contact_forces({body})) sum += force;
    CHECK(norm(sum - sim.contact_force({body})) < 1e-12);
    CHECK(sim.vertex_contact_forces({body}).size() == sim.positions({body}).size());
  }
}

TEST_CASE("every array has a row for each contact, and a name of its own") {
  const RestingBox resting;
  const Simulation& sim = resting.sim;
  ContactArrays rows = contact_arrays(sim);
  std::vector<std::string> names;
  rows.for_each([&](const char* name, const auto& array) {
    CHECK(array.size() == rows.bodies.size());
    names.push_back(name);
  });
  std::ranges::sort(names);
  CHECK(std::ranges::adjacent_find(names) == names.end());
  CHECK(names.size() == 12);
}

TEST_CASE("vertices and edges inside of flat faces are told apart") {
  const RestingBox resting;
  const Simulation& sim = resting.sim;
  CHECK(inner_vertices(sim, {0}) == std::vector<int32_t>{4});  // the middle of the floor
  CHECK(inner_vertices(sim, {1}).empty());
  // Floor: 9 vertices, 8 triangles, 16 edges; box: 12 triangles, 18 edges.
  CHECK(all_edges(sim.surface_mesh()).size() == 16 + 18);
  CHECK(sim.surface_mesh().edges.size() < 16 + 18);
}
