// Stacks of sheets that their automatic contact distance keeps far apart are warned about.
#include <doctest/doctest.h>

#include <stark/geometry/shapes.h>
#include <stark/sim/scene/thin_sheets.h>

using namespace stark;

namespace {

constexpr double kPaper = 1e-4, kCotton = 1e-3;  // [m]

Scene stack(int count, double thickness, const Vec3& step, std::optional<double> contact_distance = {}) {
  Scene scene;
  for (int i = 0; i < count; ++i)
    scene.add_cloth({.mesh = make_grid(0.3, 0.2, 4, 3),
                     .material = {.thickness = thickness},
                     .position = step * static_cast<double>(i),
                     .contact_distance = contact_distance});
  return scene;
}

size_t warnings(const Scene& scene, const Settings& settings = {}) {
  return check_thin_sheets(scene, settings).size();
}

}  // namespace

TEST_CASE("a stack of thin sheets is warned about once, two of them are not") {
  const Vec3 up{0, 0, 1e-3};
  CHECK(warnings(stack(30, kPaper, up)) == 1);
  CHECK(check_thin_sheets(stack(30, kPaper, up), {}).front().find("at least") != std::string::npos);
  CHECK(warnings(stack(2, kPaper, up)) == 0);
  CHECK(warnings(stack(30, kCotton, up)) == 0);
}

TEST_CASE("sheets beside each other are no stack") { CHECK(warnings(stack(30, kPaper, {0.4, 0, 0})) == 0); }

TEST_CASE("who gave a contact distance is not warned") {
  const Vec3 up{0, 0, 1e-3};
  CHECK(warnings(stack(30, kPaper, up, 1e-3)) == 0);
  Settings settings;
  settings.contact.distance = 1e-3;
  CHECK(warnings(stack(30, kPaper, up), settings) == 0);
}

TEST_CASE("sheets that do not touch each other are no stack") {
  Scene scene = stack(3, kPaper, {0, 0, 1e-3});
  scene.disable_contact(BodyId{0}, BodyId{1});
  scene.disable_contact(BodyId{1}, BodyId{2});
  scene.disable_contact(BodyId{0}, BodyId{2});
  CHECK(warnings(scene) == 0);
}
