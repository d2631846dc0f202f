#include <stark/sim/step/step_evidence.h>

#include <doctest/doctest.h>

#include <limits>

#include <stark/geometry/shapes.h>
#include <stark/sim/simulation.h>

using namespace stark;

TEST_CASE("blocks of unknowns are named by body and vertex") {
  Scene scene;
  const TriangleMesh grid = make_grid(1.0, 1.0, 1, 1);
  const BodyId cloth = scene.add_cloth({.name = "sheet", .mesh = grid});
  scene.pin(cloth, std::vector<int32_t>{0});
  scene.add_rigid({.name = "box", .mesh = make_box({1, 1, 1}), .mass = 1.0, .position = {0, 0, 2}});
  scene.add_rigid(
      {.name = "table", .mesh = make_box({1, 1, 1}), .motion = Motion::Fixed, .position = {0, 0, -2}});
  scene.add_rod({.name = "cord", .mesh = {{{5, 0, 0}, {6, 0, 0}}}});
  const Simulation sim(scene);
  const std::vector<BodyVertices> owners = block_owners(scene, sim.model());
  const DofLayout& layout = sim.model().map().layout();
  REQUIRE(static_cast<int32_t>(owners.size()) == layout.block_count);
  int on_sheet = 0, on_box = 0, on_cord = 0;
  for (const BodyVertices& owner : owners) {
    on_sheet += owner.body == "cloth 'sheet'";
    on_box += owner.body == "rigid body 'box'";
    on_cord += owner.body == "rod 'cord'";
    CHECK(owner.vertices.size() == (owner.body == "rigid body 'box'" ? 0 : 1));
  }
  CHECK(on_sheet == 3);  // one of four is pinned
  CHECK(on_box == 2);
  CHECK(on_cord == 4);
  CHECK(owners[layout.point_block[3]].vertices == std::vector<int32_t>{3});
}

namespace {

/// A press that comes down onto a block on a table, deeper than the block is high.
StepReport pressed(double time_step) {
  Scene scene;
  scene.add_rigid({.name = "table", .mesh = make_box({1, 1, 0.1}), .motion = Motion::Fixed});
  scene.add_rigid(
      {.name = "block", .mesh = make_box({0.1, 0.1, 0.1}), .mass = 0.1, .position = {0, 0, 0.105}});
  const BodyId press = scene.add_rigid({.name = "press",
                                        .mesh = make_box({0.2, 0.2, 0.1}),
                                        .motion = Motion::Scripted,
                                        .position = {0, 0, 0.21}});
  Settings settings;
  settings.time.step = time_step;
  settings.time.min_step = 0.6 * time_step;
  Simulation sim(scene, settings);
  sim.set_pose(press, {0, 0, 0.1}, Mat3::identity());
  return sim.step();
}

}  // namespace

TEST_CASE("the evidence of a step that failed names bodies and vertices of the scene") {
  const StepReport report = pressed(0.01);
  REQUIRE(report.failed());
  const Diagnosis& diagnosis = report.diagnosis;
  CHECK(diagnosis.cause == FailureCause::BlockedMotion);
  const StepEvidence& evidence = diagnosis.evidence;
  CHECK(evidence.pushing == std::vector<std::string>{"rigid body 'press'"});
  CHECK_FALSE(evidence.prescribed_arrived);
  CHECK(evidence.is_first_step);
  REQUIRE(!evidence.gaps.empty());
  for (const NarrowGap& gap : evidence.gaps) {
    CHECK(gap.distance > 0.0);
    CHECK(gap.distance < gap.contact_distance);
    for (const BodyVertices& place : {gap.a, gap.b})
      for (const int32_t v : place.vertices) {
        CHECK(v >= 0);
        CHECK(v < 8);
      }
  }
  REQUIRE(!evidence.forces.empty());
  CHECK(evidence.forces.front().at.body == "rigid body 'block'");
  CHECK(evidence.attempts.size() == 1);
  CHECK(evidence.scene_size > 1.4);
  CHECK(report.message.find("rigid body 'press'") != std::string::npos);
}

TEST_CASE("a step that did not fail has no diagnosis") {
  Scene scene;
  scene.add_rigid({.mesh = make_box({1, 1, 1}), .mass = 1.0});
  Simulation sim(scene);
  CHECK_FALSE(static_cast<bool>(sim.step().diagnosis));
}
