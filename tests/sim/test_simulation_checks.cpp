#include <doctest/doctest.h>

#include <stark/base/error.h>
#include <stark/geometry/shapes.h>
#include <stark/sim/simulation.h>

using namespace stark;

namespace {

/// A box of 0.1 m with a gap to the table below it, both with a contact distance of 1 mm.
std::vector<std::string> findings(double gap) {
  Scene scene;
  scene.add_rigid({.name = "table", .mesh = make_box({1, 1, 0.1}), .motion = Motion::Fixed});
  scene.add_rigid(
      {.name = "box", .mesh = make_box({0.1, 0.1, 0.1}), .mass = 1.0, .position = {0, 0, 0.1 + gap}});
  return Simulation(scene).check_state();
}

}  // namespace

TEST_CASE("bodies that start well within their contact distance are found, once a pair") {
  CHECK(findings(0.01).empty());
  CHECK(findings(0.5e-3).empty());
  CHECK(findings(0.1e-3).empty());
  const std::vector<std::string> close = findings(1e-5);
  REQUIRE(close.size() == 1);
  CHECK(close[0].find("rigid body 'box'") != std::string::npos);
  CHECK(close[0].find("rigid body 'table'") != std::string::npos);
  CHECK(close[0].find("0.002 m") != std::string::npos);
}

TEST_CASE("a sheet that one narrow fold makes thin everywhere is named") {
  // A strip, its end folded back at a height; half-way to the crease the gap is half as wide.
  const auto findings_of_fold = [](double height, double stiffness) {
    Scene scene;
    const TriangleMesh strip = make_grid(0.1, 0.3, 4, 12);
    std::vector<Vec3> folded = strip.vertices;
    for (Vec3& x : folded)
      if (x.y > 0.05) x = {x.x, 0.1 - x.y, height};
    ClothDescription cloth{.name = "towel", .mesh = strip, .initial_positions = folded};
    cloth.contact_distance = 1e-3;
    if (stiffness > 0.0) cloth.contact_stiffness = stiffness;
    scene.add_cloth(cloth);
    return Simulation(scene).check_state();
  };
  CHECK(findings_of_fold(2.5e-3, 0.0).empty());
  CHECK(findings_of_fold(1.4e-3, 0.0).size() == 1);
  CHECK(findings_of_fold(1.4e-3, 1e9).empty());
  const std::vector<std::string> found = findings_of_fold(1e-4, 0.0);
  REQUIRE(found.size() == 1);
  CHECK(found[0].find("cloth 'towel'") != std::string::npos);
  CHECK(found[0].find("instead of 0.002 m") != std::string::npos);
  CHECK(found[0].find("wider folds") != std::string::npos);
}

TEST_CASE("a sheet that starts through itself is told so") {
  ClothDescription sheet{.name = "scan", .mesh = make_grid(0.4, 0.4, 4, 4)};
  for (const Vec3& x : sheet.mesh.vertices) {  // one half turned over, through the other
    const double side = x.x > 0.0 ? -0.5 : 1.0;
    sheet.initial_positions.push_back({side * x.x, x.y, x.x > 0.0 ? 0.1 - x.x : 0.0});
  }
  Scene scene;
  scene.add_cloth(sheet);
  CHECK_THROWS_WITH_AS(Simulation{scene}, doctest::Contains("'scan' intersects itself at time 0 at "),
                       InitialIntersection);
  CHECK_THROWS_WITH_AS(Simulation{scene}, doctest::Contains("or add it with self_contact = false"),
                       InitialIntersection);
  Scene free;
  sheet.self_contact = false;
  free.add_cloth(sheet);
  CHECK_NOTHROW(Simulation{free});
}

TEST_CASE("solids that start inverted are found") {
  Scene scene;
  const TetMesh mesh = make_tet_box({0.1, 0.1, 0.1}, {2, 2, 2});
  std::vector<Vec3> mirrored = mesh.vertices;
  for (Vec3& x : mirrored) x.z = -x.z;
  scene.add_solid({.name = "right", .mesh = mesh});
  scene.add_solid({.name = "wrong", .mesh = mesh, .position = {1, 0, 0}, .initial_positions = mirrored});
  const std::vector<std::string> found = Simulation(scene).check_state();
  REQUIRE(found.size() == 1);
  CHECK(found[0].find("solid 'wrong'") != std::string::npos);
}
