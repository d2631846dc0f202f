// Plain members of descriptions by name.
#include <doctest/doctest.h>

#include <set>
#include <string>

#include <stark/sim/scene/description_fields.h>
#include <stark/sim/scene/scene.h>

using namespace stark;

namespace {

template <typename Description>
std::set<std::string> names_of() {
  Description description;
  std::set<std::string> names;
  for_each_field(description, [&](const char* name, auto&) { CHECK(names.insert(name).second); });
  return names;
}

}  // namespace

TEST_CASE("a description has the fields of its kind") {
  CHECK(names_of<RigidDescription>().contains("hollow"));
  CHECK(!names_of<RigidDescription>().contains("law"));
  CHECK(names_of<ClothDescription>().contains("rest_angles"));
  CHECK(names_of<RodDescription>().contains("normal"));
  CHECK(names_of<JointDescription>().contains("break_torque"));
  CHECK(names_of<PointSet>().contains("supports"));
  CHECK(names_of<FrameDescription>().contains("carrier"));
}

TEST_CASE("fields are the members themselves") {
  RigidDescription body;
  for_each_field(body, [&](const std::string& name, auto& member) {
    if constexpr (requires { member = std::string("box"); })
      if (name == "name") member = "box";
  });
  CHECK(body.name == "box");
}
