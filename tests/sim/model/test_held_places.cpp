// Joints and attachments that hold what they find: places of all kinds of carriers, states, refusals.
#include <stark/sim/model/held_places.h>

#include <doctest/doctest.h>

#include <stark/stark.h>

using namespace stark;
using doctest::Approx;

namespace {

Settings no_contact() {
  Settings settings;
  settings.time.step = 0.01;
  settings.contact.enabled = false;
  settings.gravity = {0, 0, 0};
  return settings;
}

RigidDescription cube(const Vec3& position, const Vec3& spin = {}) {
  return {.mesh = make_box({0.1, 0.1, 0.1}), .mass = 1.0, .position = position, .angular_velocity = spin};
}

/// A square of cloth and a turning cube. Whatever is released at time 0 can hold what it finds, but for the
/// hinge and what a patch carries.
struct Loose {
  Scene scene;
  BodyId box = scene.add_rigid(cube({0, 0, 0}, {1.0, 2.0, 3.0}));
  BodyId free = scene.add_rigid(cube({0, 0, 1}, {0.0, -1.0, 0.0}));
  BodyId cloth = scene.add_cloth({.mesh = make_grid(0.2, 0.2, 2, 2)});
  JointId weld = add("fixed", world_frame({0.1, 0, 0}), body_frame(box, {0.1, 0, 0}));
  JointId ball = add("ball", body_frame(free, {0.1, 0, -0.5}), world_frame({0.1, 0, 0.5}));
  JointId on_cloth = add("fixed", patch_frame(cloth, {0, 1, 4}, {0.1, 0, 0}), body_frame(box, {0.1, 0, 0}));
  JointId hinge = add("hinge", world_frame({0, 0, 0}), body_frame(box, {0, 0, 0}));
  AttachmentId grip = scene.add_attachment(
      {.a = vertex_points(cloth, {0, 3, 8}),
       .b = {body_points(box, {{-0.1, -0.1, 0}, {-0.1, 0, 0}}), world_points({{0.1, 0.1, 0}})},
       .enabled = false});

  JointId add(const char* kind, const FrameDescription& a, const FrameDescription& b) {
    return scene.add_joint({.definition = find_joint(kind), .a = a, .b = b, .enabled = false});
  }
};

}  // namespace

TEST_CASE("what is held where it is has no residual, whatever carries it") {
  Loose loose;
  Simulation sim(loose.scene, no_contact());
  for (int i = 0; i < 20; ++i) REQUIRE_FALSE(sim.step().failed());
  const auto residual = [&](JointId joint) {
    double largest = 0.0;
    for (const double r : sim.joint_residuals(joint)) largest = std::max(largest, std::fabs(r));
    return largest;
  };
  for (const JointId joint : {loose.weld, loose.ball, loose.on_cloth}) {
    CAPTURE(joint.index);
    CHECK(residual(joint) > 0.01);
    const State before = sim.state();
    sim.hold_joint_here(joint);
    CHECK(residual(joint) < 1e-15);
    CHECK(sim.joint_enabled(joint));
    for (int i = 0; i < 5; ++i) REQUIRE_FALSE(sim.step().failed());
    CHECK(residual(joint) < 1e-5);
    CHECK(norm(sim.joint_reaction(joint).force) + norm(sim.joint_reaction(joint).torque) > 0.0);
    sim.set_state(before);
    CHECK(first_difference(sim.state(), before).empty());
    CHECK(residual(joint) > 0.01);
  }
}

TEST_CASE("pairs are held one by one, and states bring their places back") {
  Loose loose;
  Simulation sim(loose.scene, no_contact());
  for (int i = 0; i < 20; ++i) REQUIRE_FALSE(sim.step().failed());
  CHECK(sim.held_places() == sim.model().initial_places());
  CHECK(sim.state().held_place.empty());
  const State released = sim.state();
  sim.hold_pairs_here(loose.grip, std::vector<int32_t>{0, 2});
  CHECK(sim.attachment_status(loose.grip) == std::vector<int32_t>{1, 0, 1});
  CHECK(sim.state().held_place.size() == sim.model().initial_places().size());
  const std::vector<double> taken = sim.held_places();
  for (int i = 0; i < 3; ++i) REQUIRE_FALSE(sim.step().failed());
  const std::vector<Vec3> forces = sim.attachment_forces(loose.grip);
  CHECK(norm(forces[0]) > 0.0);
  CHECK(norm(forces[1]) == 0.0);
  const State held = sim.state();
  for (int i = 0; i < 3; ++i) REQUIRE_FALSE(sim.step().failed());
  const State end = sim.state();
  sim.set_state(released);
  CHECK(sim.held_places() == sim.model().initial_places());
  sim.set_state(held);
  CHECK(sim.held_places() == taken);
  for (int i = 0; i < 3; ++i) REQUIRE_FALSE(sim.step().failed());
  CHECK(first_difference(sim.state(), end).empty());
  sim.release_pairs(loose.grip, std::vector<int32_t>{0, 1, 2});
  CHECK(sim.attachment_status(loose.grip) == std::vector<int32_t>{0, 0, 0});
  State wrong = held;
  wrong.held_place.pop_back();
  CHECK_THROWS_WITH_AS(sim.set_state(wrong), doctest::Contains("'held_place' is not as long"),
                       InvalidArgument);
  sim.reset();
  CHECK(sim.state().held_place.empty());
}

TEST_CASE("what cannot hold what it finds says so, and nothing has changed") {
  Loose loose;
  Simulation sim(loose.scene, no_contact());
  const State before = sim.state();
  CHECK_THROWS_WITH_AS(sim.hold_joint_here(loose.hinge),
                       doctest::Contains("joint 'hinge' of the kind 'hinge', released at time 0: only fixed"),
                       InvalidArgument);
  CHECK_THROWS_WITH_AS(sim.hold_pairs_here(loose.grip, std::vector<int32_t>{0, 3}),
                       doctest::Contains("pair 3: must be in [0, 3)"), InvalidArgument);
  CHECK_THROWS_WITH_AS(sim.release_pairs(loose.grip, std::vector<int32_t>{-1}),
                       doctest::Contains("pair -1: must be in [0, 3)"), InvalidArgument);
  CHECK(first_difference(sim.state(), before).empty());
}

TEST_CASE("joints and attachments that hold from time 0 on keep their places") {
  Loose loose;
  JointDescription held{
      .definition = find_joint("fixed"), .a = world_frame({0, 0, 0}), .b = body_frame(loose.box, {0, 0, 0})};
  CHECK_FALSE(can_hold_here(held));
  held.enabled = false;
  CHECK(can_hold_here(held));
  held.b = patch_frame(loose.cloth, {0, 1, 4}, {0, 0, 0});
  CHECK_FALSE(can_hold_here(held));
  AttachmentDescription glue{.a = vertex_points(loose.cloth, {0}), .b = {world_points({{0, 0, 0}})}};
  CHECK_FALSE(can_hold_here(glue, glue.b.front()));
  glue.enabled = false;
  CHECK(can_hold_here(glue, glue.b.front()));
  CHECK_FALSE(can_hold_here(glue, vertex_points(loose.cloth, {0})));
}
