// Attachments of a scene: names and what is refused.
#include <doctest/doctest.h>

#include <stark/stark.h>

using namespace stark;

namespace {

struct Parts {
  Scene scene;
  BodyId box = scene.add_rigid({.name = "box", .mesh = make_box({0.1, 0.1, 0.1}), .mass = 1.0});
  BodyId cloth =
      scene.add_cloth({.name = "sheet", .mesh = make_grid(0.1, 0.1, 2, 2), .position = {0, 0, 0.1}});
};

AttachmentDescription on_patch(const Parts& parts) {
  return {.a = body_points(parts.box, {{0, 0, 0.05}}), .patch_body = parts.cloth, .patches = {{0, 1, 3}}};
}

}  // namespace

TEST_CASE("attachments get names, keep their values and are found by id") {
  Parts parts;
  AttachmentDescription nail = on_patch(parts);
  nail.break_force = 2.0;
  const AttachmentId first = parts.scene.add_attachment(nail), second = parts.scene.add_attachment(nail);
  CHECK(parts.scene.attachment(first).name == "attachment");
  CHECK(parts.scene.attachment(second).name == "attachment_2");
  CHECK(parts.scene.attachment(first).break_force == 2.0);
  CHECK(parts.scene.attachments().size() == 2);
  CHECK_THROWS_WITH_AS(parts.scene.attachment({2}), doctest::Contains("must be in [0, 2)"), InvalidArgument);
  nail.name = "attachment";
  CHECK_THROWS_WITH_AS(parts.scene.add_attachment(nail), doctest::Contains("the name is taken"),
                       InvalidArgument);
}

TEST_CASE("attachments of nothing, of other counts and of patches without area are refused") {
  Parts parts;
  const auto refused = [&](AttachmentDescription description, const char* message) {
    CHECK_THROWS_WITH_AS(parts.scene.add_attachment(std::move(description)), doctest::Contains(message),
                         InvalidArgument);
  };
  AttachmentDescription given = on_patch(parts);
  given.a = body_points(parts.box, {});
  refused(given, "has 0 points: must have at least one");
  given = on_patch(parts);
  given.a = body_directions(parts.box, {{0, 0, 1}});
  refused(given, "directions cannot be attached");
  given = on_patch(parts);
  given.patches.push_back({0, 1, 3});
  refused(given, "1 points on 2 points or patches");
  given = on_patch(parts);
  given.b = {world_points({{0, 0, 0.05}})};
  refused(given, "1 points on 2 points or patches");
  given = on_patch(parts);
  given.patches = {{0, 1, 2}};
  refused(given, "the patch (0, 1, 2) of 'sheet' has no area");
  given = on_patch(parts);
  given.patches = {{0, 1, 9}};
  refused(given, "vertex 9: must be in [0, 9)");
  given = on_patch(parts);
  given.patch_body = parts.box;
  refused(given, "patches belong to cloth and solids");
  given = on_patch(parts);
  given.break_force = -1.0;
  refused(given, "break_force = -1 N: must be > 0");
  const PointSet corner = vertex_points(parts.cloth, {4}), inside = body_points(parts.box, {{0, 0, 0.01}});
  refused({.a = corner, .b = {corner}}, "pair 0 attaches 'sheet' to itself, at vertex 4");
  refused({.a = corner, .patch_body = parts.cloth, .patches = {{4, 1, 3}}}, "'sheet' to itself, at vertex 4");
  refused({.a = corner, .b = {embedded_points(parts.cloth, {{4, 1, 3, 3}}, {{1, 0, 0, 0}})}}, "to itself");
  refused({.a = inside, .b = {body_points(parts.box, {{0, 0, 0.05}})}}, "to itself, at one rigid body");
  refused({.a = world_points({{0, 0, 0}}), .b = {world_points({{0, 0, 0}})}}, "both sides are of the world");
  CHECK(parts.scene.attachments().empty());
}
