// Contact distances: a body's own, that of the settings, one that suits the body; warnings about large ones.
#include <doctest/doctest.h>

#include <stark/geometry/shapes.h>
#include <stark/sim/scene/contact_distance.h>

using namespace stark;
using doctest::Approx;

namespace {

double of_cube(double size, const Settings& settings = {}) {
  Scene scene;
  return contact_distance(scene, scene.add_rigid({.mesh = make_box({size, size, size}), .mass = 1.0}),
                          settings);
}

double of_cloth(double size, int cells, bool self_contact = true) {
  Scene scene;
  const BodyId cloth =
      scene.add_cloth({.mesh = make_grid(size, size, cells, cells), .self_contact = self_contact});
  return contact_distance(scene, cloth, Settings{});
}

}  // namespace

TEST_CASE("the contact distance is automatic unless the body or the settings have one") {
  Settings settings;
  settings.contact.distance = 2e-3;
  CHECK(of_cube(1.0, settings) == 2e-3);
  Scene scene;
  const BodyId own = scene.add_rigid({.mesh = make_box({1, 1, 1}), .mass = 1.0, .contact_distance = 3e-3});
  CHECK(contact_distance(scene, own, settings) == 3e-3);
}

TEST_CASE("an automatic contact distance is 1 mm, and at most 1 % of a small body") {
  CHECK(of_cube(1.0) == 1e-3);
  CHECK(of_cube(100.0) == 1e-3);
  CHECK(of_cube(0.01) == Approx(0.01 * 0.01 * std::sqrt(3.0)));
}

TEST_CASE("an automatic contact distance does not make a body touch itself at rest") {
  CHECK(of_cloth(0.4, 8) == 1e-3);
  const double fine = 0.2 / 200 / std::sqrt(2.0);  // height of half a cell over its diagonal
  CHECK(of_cloth(0.2, 200) == Approx(0.5 * fine));
  CHECK(of_cloth(0.2, 200, false) == 1e-3);
  Scene scene;
  scene.add_cloth({.mesh = make_grid(0.2, 0.2, 200, 200)});
  CHECK(check_contact_distances(scene, Settings{}).empty());
}

TEST_CASE("one needle does not set the contact distance of a body") {
  TriangleMesh mesh = make_grid(0.4, 0.4, 2, 2);
  const int32_t n = static_cast<int32_t>(mesh.vertices.size());
  mesh.vertices.push_back({1.0, 0.0, 0.0});
  mesh.vertices.push_back({1.1, 0.0, 0.0});
  mesh.vertices.push_back({1.05, 1e-6, 0.0});
  mesh.triangles.push_back({n, n + 1, n + 2});
  Scene scene;
  const BodyId cloth = scene.add_cloth({.mesh = mesh});
  CHECK(contact_distance(scene, cloth, Settings{}) == Approx(1e-4));
  CHECK(check_contact_distances(scene, Settings{}).size() == 1);
}
