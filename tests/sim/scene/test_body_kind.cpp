// The table of kinds of bodies: rows in the order of the enumeration, each with what fits its descriptions.
#include <doctest/doctest.h>

#include <numbers>
#include <numeric>

#include <stark/geometry/shapes.h>
#include <stark/sim/scene/lumped_mass.h>

using namespace stark;
using doctest::Approx;

namespace {

/// A cloth of 2 m^2, a block of 6 m^3, a box of 3 kg, a rod of 2 m: one body of each kind, in their order.
Scene scene_of_all_kinds() {
  Scene scene;
  scene.add_cloth({.mesh = make_grid(1.0, 2.0, 3, 2), .material = {.density = 0.5}});
  scene.add_solid({.mesh = make_tet_box({1.0, 2.0, 3.0}, {1, 2, 1}), .material = {.density = 100.0}});
  scene.add_rigid({.mesh = make_box({1.0, 1.0, 1.0}), .mass = 3.0});
  scene.add_rod(
      {.mesh = {{{}, {0.5, 0.0, 0.0}, {2.0, 0.0, 0.0}}}, .material = {.density = 1000.0, .radius = 0.01}});
  return scene;
}

}  // namespace

TEST_CASE("a body of each kind has the mass of its material") {
  const Scene scene = scene_of_all_kinds();
  const double expected[] = {1.0, 600.0, 3.0, 2000.0 * std::numbers::pi * 1e-4};
  REQUIRE(scene.body_count() == static_cast<int32_t>(EnumNames<BodyKind>::kNames.size()));
  for (int32_t b = 0; b < scene.body_count(); ++b) {
    CAPTURE(b);
    CHECK(static_cast<int32_t>(scene.kind({b})) == b);
    CHECK(total_mass(scene, {b}) == Approx(expected[b]));
    // Vertices with positions of their own have the masses, and no others.
    const BodyKindRow& row = row_of(scene.kind({b}));
    REQUIRE((row.vertex_masses != nullptr) == has_points(scene.kind({b})));
    if (row.vertex_masses) CHECK(row.vertex_masses(scene, {b}).size() == scene.rest_vertices({b}).size());
  }
}

TEST_CASE("elements and surfaces of each kind are those of its mesh") {
  const Scene scene = scene_of_all_kinds();
  const auto elements = [&](int32_t body) { return elements_of(scene, {body}); };
  CHECK(elements(0).count() == 12);
  CHECK(elements(0).width == 3);
  CHECK(elements(1).count() == static_cast<size_t>(scene.solid_mesh({1})->element_count()));
  CHECK(elements(1).width == 4);
  CHECK(elements(2).count() == 0);
  CHECK(elements(3).vertices == std::vector<int32_t>{0, 1, 1, 2});
  CHECK(scene.surface_triangles({0}).size() == 12);
  CHECK(scene.surface_triangles({1}).size() == 2 * 2 * (1 * 2 + 2 * 1 + 1 * 1));
  CHECK(scene.surface_triangles({2}).size() == 12);
  CHECK(scene.surface_triangles({3}).empty());
  for (const int32_t b : {0, 2, 3}) CHECK(scene.solid_mesh({b}) == nullptr);
}

TEST_CASE("only what has elements has fields of rest and a material") {
  for (size_t k = 0; k < EnumNames<BodyKind>::kNames.size(); ++k) {
    const BodyKindRow& row = row_of(static_cast<BodyKind>(k));
    if (row.elements) continue;
    CHECK(row.rest_fields.empty());
    CHECK_FALSE(static_cast<bool>(row.material_scale));
  }
}

TEST_CASE("a description asked of a body of another kind is refused with both kinds") {
  const Scene scene = scene_of_all_kinds();
  CHECK_THROWS_WITH(scene.rod(scene.find("cloth")),
                    "body 'cloth' is a cloth body: a rod body is needed here");
}
