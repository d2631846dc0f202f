// Layers in scenes: what is refused and what the message says, names, defaults.
#include <doctest/doctest.h>

#include <functional>
#include <limits>

#include <stark/base/error.h>
#include <stark/geometry/shapes.h>
#include <stark/sim/scene/scene.h>
#include <support/layer_scenes.h>

using namespace stark;
using namespace stark::test;

namespace {

/// The message that a layer on the block raises; `change` may add more of the scene.
std::string refusal(const SkinDescription& skin) {
  Scene scene;
  add_block(scene);
  return message_of([&] { scene.add_skin(skin); });
}

std::string refusal(const FibresDescription& fibres) {
  Scene scene;
  add_block(scene);
  return message_of([&] { scene.add_fibres(fibres); });
}

FibresDescription along(std::vector<std::vector<int32_t>> paths) {
  return {.name = "cords", .body = {0}, .paths = std::move(paths)};
}

SkinDescription of(std::vector<Index3> triangles) {
  return {.name = "coat", .body = {0}, .triangles = std::move(triangles)};
}

}  // namespace

TEST_CASE("layers are named after their body, apart from bodies and each other") {
  Scene scene;
  const BodyId block = add_block(scene);
  const SkinId a = scene.add_skin({.body = block}), b = scene.add_skin({.body = block});
  const FibresId c = scene.add_fibres({.body = block, .paths = {{0, 1}}});
  CHECK(scene.skin(a).name == "block_skin");
  CHECK(scene.skin(b).name == "block_skin_2");
  CHECK(scene.fibres(c).name == "block_fibres");
  CHECK_FALSE(scene.contains("block_skin"));  // no body
  CHECK(contains(message_of([&] { scene.add_skin({.name = "block", .body = block}); }),
                 "skin 'block' of solid 'block': the name is taken"));
  CHECK(contains(message_of([&] { scene.add_cloth({.name = "block_skin", .mesh = make_grid(1, 1, 1, 1)}); }),
                 "is taken: names of bodies and layers must be unique"));
}

TEST_CASE("a skin without triangles covers the surface") {
  Scene scene;
  const BodyId block = add_block(scene);
  CHECK(scene.skin(scene.add_skin({.body = block})).triangles.size() == 48);
  const BodyId sheet = scene.add_cloth({.mesh = make_grid(1, 1, 2, 2)});
  CHECK(scene.skin(scene.add_skin({.body = sheet})).triangles == scene.cloth(sheet).mesh.triangles);
}

TEST_CASE("only cloth and solids have layers") {
  Scene scene;
  const BodyId box = scene.add_rigid({.name = "box", .mesh = make_box({1, 1, 1}), .mass = 1.0});
  const BodyId rod = scene.add_rod({.name = "cable", .mesh = {{{0, 0, 0}, {1, 0, 0}}}});
  CHECK(contains(message_of([&] { scene.add_skin({.body = box}); }),
                 "skin of rigid body 'box': the body must be a cloth or a solid"));
  CHECK(contains(message_of([&] { scene.add_fibres({.body = rod, .paths = {{0, 1}}}); }),
                 "fibres of rod 'cable': the body must be a cloth or a solid"));
  CHECK_THROWS_AS(scene.add_skin({.body = {7}}), InvalidArgument);
  CHECK_THROWS_AS(scene.skin({0}), InvalidArgument);
  CHECK_THROWS_AS(scene.fibres(FibresId{0}), InvalidArgument);
}

TEST_CASE("triangles of skins are checked") {
  CHECK(contains(refusal(of({{0, 1, 35}})), "skin 'coat' of solid 'block': triangle 0 refers to vertex 35"));
  CHECK(contains(refusal(of({{0, 1, -1}})), "refers to vertex -1"));
  CHECK(contains(refusal(of({{0, 1, 1}})), "uses vertex 1 twice"));
  CHECK(contains(refusal(of({{0, 1, 2}})), "triangles must not be degenerate"));
  CHECK(contains(refusal(of({{0, 1, 3}, {3, 0, 1}})), "triangles 0 and 1 have the same vertices"));
}

TEST_CASE("materials, fields and colours of layers are checked") {
  SkinDescription skin = of({});
  skin.material.thickness = -1.0;
  CHECK(contains(refusal(skin), "skin 'coat' of solid 'block': thickness = -1 m: must be > 0"));
  skin = of({});
  skin.fields["youngs_modulus"] = {{1.0, 2.0}, true};
  CHECK(contains(refusal(skin), "youngs_modulus"));
  skin = of({});
  skin.color = Color{2.0, 0.0, 0.0};
  CHECK(contains(refusal(skin), "color channel = 2"));
  FibresDescription fibres = along({{0, 1}});
  fibres.material.radius = 0.0;
  CHECK(contains(refusal(fibres), "fibres 'cords' of solid 'block': radius = 0 m: must be > 0"));
  fibres = along({{0, 1}});
  fibres.fields["axial_stiffness"] = {{1.0, 2.0}, true};
  CHECK(contains(refusal(fibres), "axial_stiffness"));
}

TEST_CASE("paths of fibres are checked") {
  CHECK(contains(refusal(along({})), "has 0 paths"));
  CHECK(contains(refusal(along({{0, 1}, {2}})), "path 1 has 1 vertices: must have at least 2"));
  CHECK(contains(refusal(along({{0, 35}})), "path 0: vertex 35: must be in [0, 35)"));
  CHECK(contains(refusal(along({{-1, 0}})), "vertex -1"));
  CHECK(contains(refusal(along({{0, 1, 1}})), "edge 1 joins vertex 1 with itself"));
  CHECK(contains(refusal(along({{0, 1, 2}, {2, 1}})),
                 "edge of the vertices 1 and 2 is there twice, the second time in path 1"));
  CHECK(contains(refusal(along({{0, 2, 1}})), "rad at point 1: must turn by less than 2.8 rad"));
}

TEST_CASE("a sharp bend is a matter of bending only") {
  FibresDescription fibres = along({{0, 2, 1}});
  fibres.bending = false;
  CHECK(refusal(fibres).empty());
}

TEST_CASE("a normal has a part across the fibre; without bending there is nothing it could mean") {
  FibresDescription fibres = along({{0, 1}});
  fibres.normal = Vec3{1, 0, 0};
  CHECK(contains(refusal(fibres), "along the first edge"));
  fibres.normal = Vec3{0, 0, 1};
  CHECK(refusal(fibres).empty());
  fibres.bending = false;
  CHECK(contains(refusal(fibres), "normal is given: must be left out with bending = false"));
  fibres.normal.reset();
  fibres.rest_shape = RestShape::Straight;
  CHECK(contains(refusal(fibres), "rest_shape = straight is given: must be left out"));
}

TEST_CASE("edges that collapse at time 0 are refused where they need a direction") {
  Scene scene;
  SolidDescription block = block_description();
  block.initial_positions = block.mesh.vertices;
  block.initial_positions[1] = block.initial_positions[0];
  scene.add_solid(block);
  CHECK(contains(message_of([&] { scene.add_fibres(along({{0, 1, 2}})); }),
                 "path 0 at time 0: edge 0 has a length of 0 m"));
}
