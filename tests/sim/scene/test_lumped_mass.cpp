// Masses of bodies and layers against volumes, areas and lengths.
#include <doctest/doctest.h>

#include <numbers>
#include <numeric>

#include <stark/geometry/shapes.h>
#include <stark/sim/scene/lumped_mass.h>
#include <support/layer_scenes.h>

using namespace stark;
using namespace stark::test;
using doctest::Approx;

namespace {

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

}  // namespace

TEST_CASE("the mass of a body is that of its elements and of all of its layers") {
  Scene scene;
  const BodyId block = add_block(scene);  // 1 m^3
  CHECK(total_mass(scene, block) == Approx(scene.solid(block).material.density));
  const SkinId skin = scene.add_skin({.body = block, .material = {.density = 3.0}});
  CHECK(total_mass(scene, scene.skin(skin)) == Approx(6.0 * 3.0));
  const FibresId fibres = scene.add_fibres(
      {.body = block, .paths = {{0, 1, 2}, {6, 7}}, .material = {.density = 2000.0, .radius = 0.01}});
  const double per_length = 2000.0 * std::numbers::pi * 1e-4;
  CHECK(total_mass(scene, scene.fibres(fibres)) == Approx(1.5 * per_length));
  CHECK(total_mass(scene, block) == Approx(1000.0 + 18.0 + 1.5 * per_length));
}

TEST_CASE("an edge gives half of its mass to each end; a ring closes") {
  Scene scene;
  const BodyId sheet = scene.add_cloth({.mesh = make_grid(2, 2, 2, 2)});
  FibresDescription fibres{.body = sheet, .paths = {{0, 1, 4, 3, 0}}};
  fibres.fields["density"] = {{1000.0, 2000.0, 3000.0, 4000.0}, true};
  const double area = std::numbers::pi * fibres.material.radius * fibres.material.radius;
  const auto masses = lumped_masses(scene, scene.fibres(scene.add_fibres(fibres)));
  CHECK(masses[0] == Approx(2500.0 * area));
  CHECK(masses[1] == Approx(1500.0 * area));
  CHECK(masses[4] == Approx(2500.0 * area));
  CHECK(masses[3] == Approx(3500.0 * area));
  CHECK(masses[8] == 0.0);
}

TEST_CASE("a skin gives a third of each triangle to its vertices, and nothing elsewhere") {
  Scene scene;
  const BodyId sheet = scene.add_cloth({.mesh = make_grid(1, 1, 1, 1)});
  const SkinId skin = scene.add_skin(
      {.body = sheet, .triangles = {scene.cloth(sheet).mesh.triangles[0]}, .material = {.density = 6.0}});
  const auto masses = lumped_masses(scene, scene.skin(skin));
  CHECK(sum(masses) == Approx(3.0));
  int used = 0;
  for (const double m : masses) used += m > 0.0 ? 1 : 0;
  CHECK(used == 3);
}

TEST_CASE("rods and rigid bodies") {
  Scene scene;
  const BodyId rod = scene.add_rod(
      {.mesh = {{{0, 0, 0}, {1, 0, 0}, {3, 0, 0}}}, .material = {.density = 1000.0, .radius = 0.01}});
  CHECK(total_mass(scene, rod) == Approx(3000.0 * std::numbers::pi * 1e-4));
  const BodyId box = scene.add_rigid({.mesh = make_box({1, 1, 1}), .mass = 2.5});
  CHECK(total_mass(scene, box) == 2.5);
}
