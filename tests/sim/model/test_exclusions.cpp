// Contact of what joints and attachments have released: when it comes back, what is said until then.
#include <doctest/doctest.h>

#include <algorithm>

#include <stark/base/error.h>
#include <stark/base/rotation.h>
#include <stark/geometry/shapes.h>
#include <stark/sim/model/exclusions.h>
#include <stark/sim/scene/registry.h>
#include <stark/sim/simulation.h>

using namespace stark;

namespace {

constexpr Vec3 kAnchor{0.0, 0.0, 0.0};

/// Two boxes of 10 cm, the second `offset` beside the first, that hinges hold without contact.
Scene hinged_boxes(const Vec3& offset, int hinges = 1, bool enabled = true) {
  Scene scene;
  const BodyId base =
      scene.add_rigid({.name = "base", .mesh = make_box({0.1, 0.1, 0.1}), .motion = Motion::Fixed});
  const BodyId arm =
      scene.add_rigid({.name = "arm", .mesh = make_box({0.1, 0.1, 0.1}), .mass = 0.1, .position = offset});
  for (int n = 0; n < hinges; ++n)
    scene.add_joint({.definition = find_joint("fixed"),
                     .a = body_frame(base, kAnchor),
                     .b = body_frame(arm, kAnchor - offset),
                     .enabled = enabled,
                     .contact = false});
  return scene;
}

Settings without_gravity() {
  Settings settings;
  settings.gravity = {0, 0, 0};
  return settings;
}

bool says_overlap(const StepReport& report) {
  return std::ranges::find(report.caveats, Caveat::ReleasedOverlap) != report.caveats.end();
}

}  // namespace

TEST_CASE("exclusions are listed once, with all that hold them") {
  const Scene scene = hinged_boxes({0, 0, 0.2}, 2);
  const std::vector<Exclusion> found = find_exclusions(scene, true);
  REQUIRE(found.size() == 1);
  CHECK(found[0].body == 0);
  CHECK(found[0].vertex == Exclusion::kWhole);
  CHECK(found[0].other == 1);
  CHECK(found[0].joints == std::vector<int32_t>{0, 1});
}

TEST_CASE("bodies that a joint releases apart touch each other from then on") {
  Simulation sim(hinged_boxes({0, 0, 0.13}));
  const BodyId arm = sim.scene().find("arm");
  for (int n = 0; n < 5; ++n) CHECK(sim.step().caveats.empty());
  CHECK(sim.state().contact_regained.empty());
  sim.set_joint_enabled({0}, false);
  for (int n = 0; n < 60; ++n) {
    REQUIRE_FALSE(sim.step().failed());
    CHECK(sim.report().caveats.empty());
  }
  CHECK(sim.state().contact_regained == std::vector<int64_t>{0});
  CHECK(sim.position(arm).z > 0.1);  // it fell 3 cm and rests on the other box
  CHECK(sim.position(arm).z < 0.11);
}

TEST_CASE("an exclusion ends with the last joint that holds it, and begins again with the first") {
  Simulation sim(hinged_boxes({0, 0, 0.13}, 2), without_gravity());
  sim.set_joint_enabled({0}, false);
  sim.step();
  CHECK(sim.state().contact_regained.empty());
  sim.set_joint_enabled({1}, false);
  sim.step();
  CHECK(sim.state().contact_regained == std::vector<int64_t>{0});
  sim.set_joint_enabled({1}, true);
  sim.step();
  CHECK(sim.state().contact_regained.empty());
}

TEST_CASE("bodies that are released overlapping are named until they are apart") {
  Scene scene = hinged_boxes({0, 0, 0.09});
  Simulation sim(scene, without_gravity());
  const BodyId arm = scene.find("arm");
  State state = sim.state();
  state.joint_enabled = {0.0};
  state.body_velocity[1] = {0, 0, 0.3};  // 5 mm a step
  sim.set_state(state);
  for (int n = 0; n < 2; ++n) {
    const StepReport& report = sim.step();
    CHECK(says_overlap(report));
    CHECK(report.message.find("'base' and 'arm'") != std::string::npos);
    CHECK(report.message.find("joint 'fixed'") != std::string::npos);
  }
  CHECK(sim.position(arm).z == doctest::Approx(0.1));
  sim.step();  // 0.1 m is touching, or less than rounding apart
  CHECK(sim.position(arm).z == doctest::Approx(0.105));
  CHECK_FALSE(says_overlap(sim.step()));
  CHECK(sim.state().contact_regained == std::vector<int64_t>{0});
  // From now on it cannot go back in.
  state = sim.state();
  state.body_velocity[1] = {0, 0, -1.0};
  sim.set_state(state);
  for (int n = 0; n < 10; ++n) REQUIRE_FALSE(sim.step().failed());
  CHECK(sim.position(arm).z > 0.1);
}

TEST_CASE("a body released inside another one is not apart") {
  Scene scene;
  const BodyId shell =
      scene.add_rigid({.name = "block", .mesh = make_box({0.2, 0.2, 0.2}), .motion = Motion::Fixed});
  const BodyId core = scene.add_rigid({.name = "core", .mesh = make_box({0.1, 0.1, 0.1}), .mass = 0.1});
  scene.add_joint({.definition = find_joint("fixed"),
                   .a = body_frame(shell, kAnchor),
                   .b = body_frame(core, kAnchor),
                   .contact = false});
  Simulation sim(scene, without_gravity());
  sim.set_joint_enabled({0}, false);
  CHECK(says_overlap(sim.step()));
  CHECK(sim.state().contact_regained.empty());
}

TEST_CASE("a release of bodies that overlap can be refused") {
  Settings settings = without_gravity();
  settings.contact.released_overlap = ReleasedOverlap::Refuse;
  Simulation sim(hinged_boxes({0, 0, 0.09}), settings);
  REQUIRE_FALSE(sim.step().failed());
  sim.set_joint_enabled({0}, false);
  const State before = sim.state();
  CHECK_THROWS_WITH_AS(sim.step(), doctest::Contains("'base' and 'arm' overlap"), InitialIntersection);
  CHECK(sim.state() == before);
  sim.set_joint_enabled({0}, true);
  CHECK_FALSE(sim.step().failed());
}

TEST_CASE("contact that comes back within its distance does not throw bodies apart") {
  Settings settings = without_gravity();
  settings.contact.distance = 0.005;
  Simulation sim(hinged_boxes({0, 0, 0.101}), settings);
  sim.set_joint_enabled({0}, false);
  for (int n = 0; n < 10; ++n) REQUIRE_FALSE(sim.step().failed());
  CHECK(sim.state().contact_regained == std::vector<int64_t>{0});
  CHECK(norm(sim.linear_velocity(sim.scene().find("arm"))) < 1e-6);
}

TEST_CASE("contact that comes back nearer than the bodies have been is not thrown apart either") {
  Settings settings = without_gravity();
  settings.contact.distance = 0.005;
  Scene scene = hinged_boxes({0, 0, 0.101});
  Simulation sim(scene, settings);
  State state = sim.state();
  // A pair that has started within its contact distance before, at its very end.
  state.contact_close_bodies = {group_code(0, 1)};
  state.contact_close_distance = {0.00999};
  state.joint_enabled = {0.0};
  sim.set_state(state);
  for (int n = 0; n < 10; ++n) REQUIRE_FALSE(sim.step().failed());
  CHECK(sim.state().contact_regained == std::vector<int64_t>{0});
  CHECK(sim.state().contact_close_bodies.size() == 1);
  REQUIRE(sim.close_bodies().size() == 1);
  CHECK(sim.close_bodies()[0] == std::tuple(0, 1, sim.state().contact_close_distance[0]));
  CHECK(norm(sim.linear_velocity(sim.scene().find("arm"))) < 1e-6);
}

TEST_CASE("which exclusions are over is a part of the state") {
  const Scene scene = hinged_boxes({0, 0, 0.13}, 1, false);
  Simulation sim(scene);
  for (int n = 0; n < 10; ++n) sim.step();
  const State before = sim.state();
  CHECK(before.contact_regained == std::vector<int64_t>{0});
  sim.step();
  const State after = sim.state();
  Simulation other(scene);
  REQUIRE(other.resume(before, 1e300, after));
  CHECK(other.state() == after);
  for (int n = 0; n < 30; ++n) sim.step(), other.step();
  CHECK(other.state() == sim.state());
  sim.set_state(before);
  sim.step();
  CHECK(sim.state() == after);
  State wrong = before;
  wrong.contact_regained = {1};
  CHECK_THROWS_AS(sim.set_state(wrong), InvalidArgument);
}

TEST_CASE("places that were clear with an exclusion are looked at again without it") {
  Simulation sim(hinged_boxes({0, 0, 0.09}), without_gravity());
  const State held = sim.state();
  sim.set_state(held);
  State over = held;
  over.joint_enabled = {0.0};
  over.contact_regained = {0};
  CHECK_THROWS_AS(sim.set_state(over), InitialIntersection);
  CHECK(sim.state() == held);
  sim.set_state(held);
  CHECK_FALSE(sim.step().failed());
}

TEST_CASE("vertices whose attachment breaks touch the other body again, one by one") {
  Scene scene;
  const BodyId box =
      scene.add_rigid({.name = "box", .mesh = make_box({0.2, 0.2, 0.2}), .motion = Motion::Fixed});
  const BodyId cloth = scene.add_cloth({.name = "cloth",
                                        .mesh = make_grid(0.1, 0.1, 4, 4),
                                        .material = materials::cotton(),
                                        .position = {0, 0, 0.103}});
  std::vector<int32_t> vertices;
  std::vector<Vec3> places;
  for (int32_t v = 0; v < 25; ++v) {
    vertices.push_back(v);
    places.push_back(scene.initial_positions(cloth)[v]);
  }
  scene.add_attachment(
      {.a = vertex_points(cloth, vertices), .b = {body_points(box, places)}, .break_force = 1e-6});
  Simulation sim(scene);
  for (int n = 0; n < 40; ++n) {
    REQUIRE_FALSE(sim.step().failed());
    CHECK(sim.report().caveats.empty());
  }
  CHECK(sim.state().contact_regained.size() == 25);
  for (const Vec3& x : sim.positions(cloth)) CHECK(x.z > 0.1);
}

TEST_CASE("vertices whose contact is back are looked at when the rest of their body is released") {
  // Glue without contact of the bodies has broken at two corners, which were apart and went into the base.
  Scene scene;
  const BodyId base =
      scene.add_rigid({.name = "base", .mesh = make_box({0.4, 0.4, 0.2}), .motion = Motion::Fixed});
  const BodyId arm = scene.add_rigid(
      {.name = "arm", .mesh = make_box({0.1, 0.1, 0.1}), .mass = 0.1, .position = {0, 0, 0.16}});
  std::vector<int32_t> vertices;
  std::vector<Vec3> places;
  std::vector<double> broken, released;
  State state;
  const std::vector<Vec3> x = scene.initial_positions(arm);
  for (int32_t v = 0; v < static_cast<int32_t>(x.size()); ++v) {
    if (x[v].z > 0.16) continue;
    vertices.push_back(v);
    places.push_back(x[v]);
    broken.push_back(x[v].x > 0.0 ? -1.0 : 1.0);
    released.push_back(x[v].x > 0.0 ? -1.0 : 0.0);
    if (x[v].x > 0.0) state.contact_regained.push_back(static_cast<int64_t>(vertices.size()));
  }
  REQUIRE(vertices.size() == 4);
  scene.add_attachment(
      {.a = vertex_points(arm, vertices), .b = {body_points(base, places)}, .contact = false});
  Simulation sim(scene, without_gravity());
  const std::vector<int64_t> regained = state.contact_regained;
  state = sim.state();
  state.contact_regained = regained;
  state.attachment_held = broken;
  state.body_rotation[1] = exp_rotation({0, 0.35, 0}) * state.body_rotation[1];
  sim.set_state(state);
  CHECK(sim.state().contact_regained == regained);
  state.attachment_held = released;
  sim.set_state(state);
  CHECK(says_overlap(sim.step()));
  CHECK_FALSE(std::ranges::binary_search(sim.state().contact_regained, 0));
}

TEST_CASE("a body attached to itself keeps what is attached from what is near the other end alone") {
  Scene scene;
  const BodyId cloth = scene.add_cloth(
      {.name = "cloth", .mesh = make_grid(0.1, 0.1, 10, 10), .material = materials::cotton()});
  const Simulation sim(scene);
  scene.add_attachment({.a = vertex_points(cloth, {0}), .b = {vertex_points(cloth, {120})}});
  const std::vector<Exclusion> found = find_exclusions(scene, true);
  REQUIRE(found.size() == 2);
  CHECK(found[0].vertex == 0);
  CHECK(found[0].near == std::vector<int32_t>{120});
  CHECK(found[1].vertex == 120);
  CHECK(find_exclusions(scene, false).empty());
  const Exclusions exclusions(found, PairFilter(1), sim.model().bodies());
  // Two edges, straight or along a diagonal, from the corner.
  CHECK(exclusions[0].near.size() >= 6);
  CHECK(exclusions[0].near.size() <= 9);
  CHECK(exclusions.concerns(0, std::vector<int32_t>{5, 98, 3}));
  CHECK_FALSE(exclusions.concerns(0, std::vector<int32_t>{0, 60, 87}));
  const PairFilter filter = exclusions.filter({});
  CHECK(filter.allowed(0, 0));
  const std::array<int32_t, 3> corner{0, 1, 11}, near{98, 97, 87}, far{63, 64, 75};
  CHECK(filter.excluded(corner, 0, near, 0));
  CHECK_FALSE(filter.excluded(corner, 0, far, 0));
}

TEST_CASE("sewn pairs keep contact away before they meet, until they break") {
  Scene scene;
  for (const double z : {0.0, 0.05})
    scene.add_cloth({.mesh = make_grid(0.1, 0.1, 2, 2), .position = {0, 0, z}});
  AttachmentDescription seam{.a = vertex_points({0}, {0}), .b = {vertex_points({1}, {0})}, .enabled = false};
  for (const bool sewn : {false, true}) {
    Scene other = scene;
    seam.sewn = sewn;
    other.add_attachment(seam);
    Simulation sim(other, without_gravity());
    sim.step();
    CHECK(sim.state().contact_regained.empty() == sewn);
    CHECK(sim.attachment_gaps({0})[0] == doctest::Approx(0.05));
    State state = sim.state();
    state.attachment_held = {-1.0};
    sim.set_state(state);
    sim.step();
    CHECK(sim.state().contact_regained.size() == 2);
  }
}
