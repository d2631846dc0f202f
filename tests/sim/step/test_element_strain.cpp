#include <stark/sim/step/element_strain.h>

#include <doctest/doctest.h>

#include <cmath>

#include <stark/geometry/shapes.h>

using namespace stark;

TEST_CASE("a solid at rest has no strained elements") {
  Scene scene;
  const TetMesh mesh = make_tet_box({1, 1, 1}, {2, 2, 2});
  const BodyId cube = scene.add_solid({.mesh = mesh});
  CHECK(find_strained_elements(scene, cube, mesh.vertices, 5).empty());
  // Neither has one that only moved.
  std::vector<Vec3> moved = mesh.vertices;
  for (Vec3& x : moved) x += Vec3{3, -2, 1};
  CHECK(find_strained_elements(scene, cube, moved, 5).empty());
}

TEST_CASE("inverted elements come first, then the most stretched ones") {
  for (const bool quadratic : {false, true}) {
    CAPTURE(quadratic);
    Scene scene;
    SolidMesh mesh = make_tet_box({1, 1, 1}, {1, 1, 1});
    if (quadratic) mesh = to_quadratic(mesh);
    const BodyId cube = scene.add_solid({.name = "cube", .mesh = mesh});
    std::vector<Vec3> x = mesh.vertices;
    for (Vec3& p : x) p.z *= -0.5;
    const std::vector<StrainedElement> found = find_strained_elements(scene, cube, x, 3);
    REQUIRE(found.size() == 3);
    for (const StrainedElement& element : found) {
      CHECK(element.size == doctest::Approx(-0.5));
      CHECK(element.stretch == doctest::Approx(0.5));  // edges along z
      CHECK(std::isinf(severity(element)));
      CHECK(element.at.body == "solid 'cube'");
      CHECK_FALSE(element.is_prescribed);
    }
  }
}

TEST_CASE("strained triangles and rods are found, and whether all their vertices are pinned") {
  Scene scene;
  const TriangleMesh grid = make_grid(1.0, 1.0, 4, 4);
  const BodyId cloth = scene.add_cloth({.name = "sheet", .mesh = grid});
  std::vector<Vec3> x = grid.vertices;
  x[grid.triangles[5][0]] += Vec3{0, 0, 2};
  scene.pin(cloth, std::vector<int32_t>(grid.triangles[5].begin(), grid.triangles[5].end()));
  const std::vector<StrainedElement> found = find_strained_elements(scene, cloth, x, 100);
  REQUIRE(!found.empty());
  CHECK(found.front().stretch == doctest::Approx(std::hypot(2.0, 0.25) / 0.25).epsilon(0.05));
  bool has_prescribed = false;
  for (size_t k = 0; k < found.size(); ++k) {
    CHECK((found[k].element == 5) == found[k].is_prescribed);
    has_prescribed = has_prescribed || found[k].is_prescribed;
    if (k > 0) CHECK(severity(found[k - 1]) >= severity(found[k]));
  }
  CHECK(has_prescribed);

  const BodyId rod = scene.add_rod({.mesh = {{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}}});
  const std::vector<Vec3> bent{{0, 0, 0}, {1, 0, 0}, {1, 3, 0}};
  const std::vector<StrainedElement> edges = find_strained_elements(scene, rod, bent, 5);
  REQUIRE(edges.size() == 1);
  CHECK(edges[0].element == 1);
  CHECK(edges[0].size == doctest::Approx(3.0));
}

TEST_CASE("the stretch between pins is measured along the body") {
  Scene scene;
  const TriangleMesh grid = make_grid(1.0, 0.5, 8, 4);
  const BodyId cloth = scene.add_cloth({.mesh = grid});
  CHECK_FALSE(find_stretched_pins(scene, cloth, grid.vertices).has_value());
  int32_t left = 0, right = 0;
  for (int32_t v = 0; v < static_cast<int32_t>(grid.vertices.size()); ++v) {
    if (grid.vertices[v].x < grid.vertices[left].x) left = v;
    if (grid.vertices[v].x > grid.vertices[right].x) right = v;
  }
  scene.pin(cloth, std::vector{left, right});
  std::vector<Vec3> x = grid.vertices;
  const std::optional<PinPair> rest = find_stretched_pins(scene, cloth, x);
  REQUIRE(rest.has_value());
  CHECK(rest->stretch() <= 1.0 + 1e-12);
  x[right].x += 2.0;
  const std::optional<PinPair> pulled = find_stretched_pins(scene, cloth, x);
  REQUIRE(pulled.has_value());
  CHECK(pulled->distance == doctest::Approx(norm(x[right] - x[left])));
  CHECK(pulled->length == doctest::Approx(rest->length));
  CHECK(pulled->stretch() > 2.0);
}
