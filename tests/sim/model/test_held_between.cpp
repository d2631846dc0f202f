#include <stark/sim/model/held_between.h>

#include <doctest/doctest.h>

#include <stark/geometry/shapes.h>
#include <stark/sim/scene/registry.h>
#include <stark/sim/simulation.h>

using namespace stark;

namespace {

Contact between(BodyId a, BodyId b) { return {.group_a = a.index, .group_b = b.index}; }

/// A table, a press, and two blocks.
struct Pressed {
  Scene scene;
  BodyId table = add("table", Motion::Fixed, 0.0), low = add("low", Motion::Dynamic, 2.0),
         high = add("high", Motion::Dynamic, 4.0), press = add("press", Motion::Scripted, 6.0);

  BodyId add(const std::string& name, Motion motion, double z) {
    return scene.add_rigid({.name = name,
                            .mesh = make_box({1, 1, 1}),
                            .motion = motion,
                            .mass = motion == Motion::Dynamic ? std::optional(1.0) : std::nullopt,
                            .position = {0, 0, z}});
  }
  bool holds(const std::vector<Contact>& contacts) const {
    const Simulation sim(scene);
    return is_something_between(scene, sim.model(), contacts);
  }
};

}  // namespace

TEST_CASE("what touches one prescribed body, however often, is not between two") {
  const Pressed all;
  CHECK_FALSE(all.holds({}));
  CHECK_FALSE(all.holds({between(all.high, all.press)}));
  CHECK_FALSE(all.holds({between(all.press, all.high), between(all.high, all.press)}));
  CHECK_FALSE(all.holds({between(all.high, all.press), between(all.low, all.table)}));
  CHECK_FALSE(all.holds({between(all.table, all.press)}));  // nothing solves for either
}

TEST_CASE("what hangs together is between what it touches") {
  const Pressed all;
  const std::vector<Contact> contacts{between(all.high, all.press), between(all.low, all.table),
                                      between(all.low, all.high)};
  CHECK(all.holds(contacts));
  CHECK(all.holds({contacts[2], contacts[1], contacts[0]}));
  CHECK(all.holds({between(all.low, all.press), between(all.low, all.table)}));
}

TEST_CASE("a joint to the world holds, and pins of a body hold it in two places") {
  Pressed all;
  all.scene.add_joint(
      {.definition = find_joint("ball"), .a = world_frame({0, 0, 4}), .b = body_frame(all.high, {0, 0, 0})});
  CHECK_FALSE(all.holds({between(all.low, all.press)}));
  CHECK(all.holds({between(all.high, all.press)}));
  CHECK(all.holds({between(all.low, all.press), between(all.low, all.high)}));
  const BodyId sheet =
      all.scene.add_cloth({.name = "sheet", .mesh = make_grid(1.0, 1.0, 1, 1), .position = {0, 0, 9}});
  all.scene.pin(sheet, std::vector<int32_t>{0});
  CHECK(all.holds({}));
}
