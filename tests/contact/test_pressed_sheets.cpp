// Sheets between two bodies, found by the contacts of their vertices.
#include <doctest/doctest.h>

#include <stark/contact/pressed_sheets.h>
#include <stark/geometry/shapes.h>

#include "support/collision_scenes.h"

using namespace stark;
using test::SceneBuilder;

namespace {

/// A sheet between two boxes; a second sheet beside them.
AreaWeights make_areas() {
  SceneBuilder scene;
  scene.add_mesh(make_box({1, 1, 0.1}), {0, 0, -0.1});
  scene.add_mesh(make_grid(1.0, 1.0, 4, 4));
  scene.add_mesh(make_box({1, 1, 0.1}), {0, 0, 0.1});
  scene.add_mesh(make_grid(1.0, 1.0, 4, 4), {2, 0, 0});
  const std::vector<uint8_t> is_sheet{0, 1, 0, 1};
  return {scene.surface, scene.x, {}, is_sheet, std::vector<double>(4, 0.01)};
}

struct Pressing {
  std::vector<Contact> contacts;
  std::vector<Vec3> forces;

  void add(int32_t point, int32_t of, int32_t other, double distance, const Vec3& force) {
    Contact contact;
    contact.key = {PairKind::PointTriangle, point, static_cast<int32_t>(contacts.size())};
    contact.group_a = of;
    contact.group_b = other;
    contact.distance = distance;
    contact.stiffness = 1.0;
    contacts.push_back(contact);
    forces.push_back(force);
  }
};

constexpr int32_t kLower = 0, kSheet = 1, kUpper = 2, kOtherSheet = 3;

}  // namespace

TEST_CASE("a sheet is pressed where forces on a vertex are opposite, or where it is in between") {
  const AreaWeights areas = make_areas();
  const std::vector<PressedSheet> expected{{kSheet, kLower, kUpper}};
  const auto found = [&](const Pressing& p) { return find_pressed_sheets(areas, p.contacts, p.forces); };

  Pressing of_sheet;
  of_sheet.add(8, kSheet, kLower, 0.001, {0, 0, 2});
  of_sheet.add(8, kSheet, kUpper, 0.001, {0, 0.1, -1});
  CHECK(found(of_sheet) == expected);

  Pressing of_body;
  of_body.add(40, kUpper, kLower, 0.003, {0, 0, 2});
  of_body.add(40, kUpper, kSheet, 0.001, {0, 0, 1});
  CHECK(found(of_body) == expected);

  Pressing beyond = of_body;  // the sheet lies behind the other body
  std::swap(beyond.contacts[0].distance, beyond.contacts[1].distance);
  CHECK(found(beyond).empty());

  Pressing same_side = of_sheet;  // both bodies are below it
  same_side.forces[1] = {0, 0, 1};
  CHECK(found(same_side).empty());

  Pressing elsewhere;
  elsewhere.add(8, kSheet, kLower, 0.001, {0, 0, 2});
  elsewhere.add(9, kSheet, kUpper, 0.001, {0, 0, -2});
  CHECK(found(elsewhere).empty());

  Pressing of_sheets;
  of_sheets.add(8, kSheet, kLower, 0.001, {0, 0, 2});
  of_sheets.add(8, kSheet, kOtherSheet, 0.001, {0, 0, -2});
  CHECK(found(of_sheets).empty());
}
