// Friction of a scene: which coefficients pairs have, whose direction rules, what is refused. Messages are
// tested through Python (tests/python/physics/test_anisotropic_friction.py).
#include <doctest/doctest.h>

#include <cmath>

#include <stark/base/error.h>
#include <stark/geometry/shapes.h>
#include <stark/sim/model/model.h>
#include <stark/sim/scene/scene.h>

using namespace stark;

namespace {

ClothDescription cloth(const std::string& name) {
  return {.name = name, .mesh = make_grid(1.0, 1.0, 2, 2), .material = materials::cotton()};
}

}  // namespace

TEST_CASE("friction: the pair's own value, else the geometric mean with the default standing in") {
  Scene scene;
  auto rough = cloth("rough"), smooth = cloth("smooth"), plain = cloth("plain");
  rough.friction = 0.9;
  smooth.friction = 0.1;
  const BodyId a = scene.add_cloth(rough), b = scene.add_cloth(smooth), c = scene.add_cloth(plain);
  CHECK(scene.default_friction() > 0.0);  // no silent zero
  scene.set_default_friction(0.4);
  CHECK(scene.friction(a, b).sticking == doctest::Approx(0.3).epsilon(1e-15));
  CHECK(scene.friction(a, c).sticking == doctest::Approx(0.6).epsilon(1e-15));
  CHECK(scene.friction(a, a).sticking == 0.9);
  CHECK(scene.friction(c, c).sticking == 0.4);
  scene.set_friction(b, a, 0.7);
  CHECK(scene.friction(a, b).sticking == 0.7);
  CHECK(scene.friction(b, a).sliding == 0.7);
  scene.set_friction(c, c, 0.0);
  CHECK(scene.friction(c, c).sticking == 0.0);
  scene.set_friction(b, a, {0.5, 0.4});
  CHECK(scene.friction(a, b).sticking == 0.5);
  CHECK(scene.friction(a, b).sliding == 0.4);
  CHECK_THROWS_AS(scene.set_friction(a, b, -0.1), InvalidArgument);
  CHECK_THROWS_AS(scene.set_friction(a, b, {0.4, 0.5}), InvalidArgument);
  CHECK_THROWS_AS(scene.set_friction(a, b, {0.4, -0.1}), InvalidArgument);
  CHECK_THROWS_AS(scene.set_friction(a, {9}, 0.1), InvalidArgument);
  CHECK_THROWS_AS(scene.set_default_friction(std::nan("")), InvalidArgument);
}

TEST_CASE("anisotropic friction: the larger coefficient and shares, in the direction of the first body") {
  Scene scene;
  const BodyId a = scene.add_cloth(cloth("a")), b = scene.add_cloth(cloth("b"));
  CHECK_FALSE(scene.friction(a, b).is_anisotropic());
  scene.set_anisotropic_friction(b, a, {0.2, 0.8, 0.5});
  CHECK(scene.has_anisotropic_friction());
  const FrictionCoefficient mu = scene.friction(a, b);
  CHECK(mu.sticking == 0.8);
  CHECK(mu.sliding == 0.4);
  CHECK(mu.along == doctest::Approx(0.25).epsilon(1e-15));
  CHECK(mu.across == 1.0);
  CHECK(mu.frame == -1);  // neither has a direction yet
  CHECK_THROWS_AS(scene.check_friction(), InvalidArgument);
  Energies energies;
  CHECK_THROWS_AS(Model(scene, {}, energies), InvalidArgument);
  scene.set_surface_directions(a, {{1, 0, 0}});
  CHECK(scene.friction(a, b).frame == a.index);
  scene.set_surface_directions(b, {{0, 1, 0}});
  CHECK(scene.friction(a, b).frame == b.index);  // named first
  CHECK(scene.friction(b, a).frame == b.index);
  scene.set_surface_directions(a, {});
  CHECK(scene.surface_directions(a).empty());
  CHECK_NOTHROW(scene.check_friction());
  // Equal ones need no direction.
  scene.set_anisotropic_friction(a, b, {0.3, 0.3, 1.0});
  CHECK_FALSE(scene.has_anisotropic_friction());
  CHECK(scene.friction(a, b).sliding == 0.3);
}

TEST_CASE("surfaces get as many directions as they have triangles on the bodies that have some") {
  Scene scene;
  const BodyId sheet = scene.add_cloth(cloth("sheet"));
  const BodyId cube = scene.add_solid(
      {.name = "cube", .mesh = make_tet_box({1, 1, 1}, {2, 2, 2}), .material = materials::soft_rubber()});
  scene.set_anisotropic_friction(sheet, cube, {0.2, 0.8});
  CHECK(scene.surface_triangles(sheet).size() == 8);
  CHECK(scene.surface_triangles(cube).size() == 48);
  scene.set_surface_directions(cube, std::vector<Vec3>(48, Vec3{1, 0, 0}));
  CHECK_THROWS_AS(scene.set_surface_directions(cube, std::vector<Vec3>(47, Vec3{1, 0, 0})), InvalidArgument);
  CHECK_THROWS_AS(scene.set_surface_directions(cube, {{0, 0, 0}}), InvalidArgument);
  CHECK_THROWS_AS(scene.set_surface_directions(cube, {{NAN, 0, 0}}), InvalidArgument);
  CHECK(scene.surface_directions(cube).size() == 48);  // as before
  const Settings settings;
  Energies energies;
  const ContactSurfaces surfaces = Model(scene, settings, energies).make_surfaces(scene, settings);
  REQUIRE(surfaces.directions.size() == surfaces.mesh.triangles.size());
  for (size_t t = 0; t < 8; ++t) CHECK(surfaces.directions[t] == TangentComponents{});
  size_t with_direction = 0;
  for (const TangentComponents& d : surfaces.directions) with_direction += d != TangentComponents{};
  CHECK(with_direction == 32);  // not on the two faces across x
  CHECK_THROWS_AS(scene.set_anisotropic_friction(sheet, cube, {-0.1, 0.5}), InvalidArgument);
  CHECK_THROWS_AS(scene.set_anisotropic_friction(sheet, cube, {0.1, 0.5, 1.1}), InvalidArgument);
}
