// The scene description: what is accepted, what is computed from it, which pairs touch, and
// that a refused body leaves the scene as it was. Messages are tested through Python
// (tests/python/test_bad_input.py).
#include <doctest/doctest.h>

#include <cmath>

#include <stark/base/error.h>
#include <stark/base/rotation.h>
#include <stark/geometry/shapes.h>
#include <stark/sim/scene/contact_distance.h>
#include <stark/sim/scene/scene.h>

using namespace stark;

namespace {

ClothDescription cloth(const std::string& name = "") {
  return {.name = name, .mesh = make_grid(1.0, 1.0, 2, 2), .material = materials::cotton()};
}
SolidDescription solid(const std::string& name = "") {
  return {.name = name, .mesh = make_tet_box({1, 1, 1}, {1, 1, 1}), .material = materials::soft_rubber()};
}
RigidDescription rigid(const std::string& name = "", Motion motion = Motion::Dynamic) {
  RigidDescription body{.name = name, .mesh = make_box({0.1, 0.2, 0.3}), .motion = motion};
  if (motion == Motion::Dynamic) body.mass = 2.0;
  return body;
}

double largest_difference(const Mat3& a, const Mat3& b) {
  double largest = 0.0;
  for (int k = 0; k < 9; ++k) largest = std::max(largest, std::fabs(a.m[k] - b.m[k]));
  return largest;
}

}  // namespace

TEST_CASE("bodies get ids in order and names of their own") {
  Scene scene;
  CHECK(scene.add_cloth(cloth()) == BodyId{0});
  CHECK(scene.add_cloth(cloth()) == BodyId{1});
  CHECK(scene.add_solid(solid("cheese")) == BodyId{2});
  CHECK(scene.add_rigid(rigid()) == BodyId{3});
  CHECK(scene.name({0}) == "cloth");
  CHECK(scene.name({1}) == "cloth_2");
  CHECK(scene.find("cheese") == BodyId{2});
  CHECK(scene.kind({3}) == BodyKind::Rigid);
  CHECK(scene.index_in_kind({1}) == 1);
  CHECK(scene.motion({2}) == Motion::Dynamic);
  CHECK_THROWS_AS(scene.find("chese"), InvalidArgument);
  CHECK_THROWS_AS(scene.name({4}), InvalidArgument);
  CHECK_THROWS_AS(scene.cloth({2}), InvalidArgument);
}

TEST_CASE("a refused body leaves the scene as it was") {
  Scene scene;
  scene.add_cloth(cloth("a"));
  auto twice = cloth("a");
  auto nan = cloth("b");
  nan.mesh.vertices[3].y = std::nan("");
  auto negative = rigid("c");
  negative.mass = -1.0;
  auto inverted = solid("d");
  std::swap(inverted.mesh.elements[0], inverted.mesh.elements[1]);
  CHECK_THROWS_AS(scene.add_cloth(twice), InvalidArgument);
  CHECK_THROWS_AS(scene.add_cloth(nan), InvalidMesh);
  CHECK_THROWS_AS(scene.add_rigid(negative), InvalidArgument);
  CHECK_THROWS_AS(scene.add_solid(inverted), InvalidMesh);
  CHECK(scene.body_count() == 1);
  CHECK(scene.cloths().size() == 1);
  CHECK(scene.solids().empty());
  CHECK(scene.rigids().empty());
  CHECK(scene.warnings().empty());
}

TEST_CASE("mass properties of a box agree with the closed form, also away from the origin") {
  RigidDescription body = rigid();
  for (Vec3& v : body.mesh.vertices) v += Vec3{1.0, -2.0, 3.0};
  Scene scene;
  const RigidInertia inertia = scene.rigid_inertia(scene.add_rigid(body));
  // m/12 (b^2 + c^2) and so on; rounding grows with the distance to the origin over the size, squared: 1e3
  // ulp here.
  const Mat3 exact = Mat3::diagonal(Vec3{0.04 + 0.09, 0.01 + 0.09, 0.01 + 0.04} * (2.0 / 12.0));
  CHECK(inertia.mass == doctest::Approx(2.0).epsilon(1e-14));
  CHECK(norm(inertia.center_of_mass - Vec3{1.0, -2.0, 3.0}) < 1e-12);
  CHECK(largest_difference(inertia.tensor, exact) < 1e-12);

  RigidDescription dense = rigid();
  dense.mass.reset();
  dense.density = 500.0;
  CHECK(scene.rigid_inertia(scene.add_rigid(dense)).mass == doctest::Approx(500.0 * 0.006).epsilon(1e-13));

  RigidDescription explicit_inertia = rigid();
  explicit_inertia.mass.reset();
  explicit_inertia.inertia = RigidInertia{3.0, {0, 0, 0.1}, Mat3::diagonal({1, 2, 2.5})};
  const RigidInertia kept = scene.rigid_inertia(scene.add_rigid(explicit_inertia));
  CHECK(kept.mass == 3.0);
  CHECK(kept.tensor == Mat3::diagonal({1, 2, 2.5}));
  CHECK(scene.warnings().empty());
}

TEST_CASE("an open rigid mesh with a mass is a shell, and says so") {
  Scene scene;
  RigidDescription plate{.mesh = make_grid(0.6, 0.3, 4, 4), .mass = 1.2};
  const RigidInertia inertia = scene.rigid_inertia(scene.add_rigid(plate));
  CHECK(largest_difference(inertia.tensor, Mat3::diagonal({0.1 * 0.09, 0.1 * 0.36, 0.1 * 0.45})) < 1e-14);
  REQUIRE(scene.warnings().size() == 1);
  plate.mass.reset();
  plate.density = 1.0;
  CHECK_THROWS_AS(scene.add_rigid(plate), InvalidMesh);
}

TEST_CASE("a dynamic body has exactly one source of mass; others need none") {
  Scene scene;
  RigidDescription body = rigid();
  body.density = 1.0;
  CHECK_THROWS_AS(scene.add_rigid(body), InvalidArgument);
  body.mass.reset();
  body.density.reset();
  CHECK_THROWS_AS(scene.add_rigid(body), InvalidArgument);
  CHECK(scene.rigid_inertia(scene.add_rigid(rigid("", Motion::Fixed))).mass == 0.0);
  CHECK(scene.rigid_inertia(scene.add_rigid(rigid("", Motion::Scripted))).mass == 0.0);
}

TEST_CASE("inertia tensors that no body has are refused") {
  Scene scene;
  RigidDescription body = rigid();
  body.mass.reset();
  const auto with = [&](const Mat3& tensor) {
    body.inertia = RigidInertia{1.0, {}, tensor};
    return body;
  };
  Mat3 skewed = Mat3::identity();
  skewed(0, 1) = 0.1;
  CHECK_THROWS_AS(scene.add_rigid(with(skewed)), InvalidArgument);
  CHECK_THROWS_AS(scene.add_rigid(with(Mat3::diagonal({1, 1, 2.1}))), InvalidArgument);
  CHECK_THROWS_AS(scene.add_rigid(with(Mat3::diagonal({1, 1, -1}))), InvalidArgument);
  CHECK_THROWS_AS(scene.add_rigid(with(Mat3{})), InvalidArgument);
  CHECK_NOTHROW(scene.add_rigid(with(Mat3::diagonal({1, 1, 2}))));  // a flat plate: equality is physical
}

TEST_CASE("pose and velocities give the state at time 0") {
  Scene scene;
  ClothDescription body = cloth();
  body.position = {1, 2, 3};
  body.rotation = exp_rotation({0, 0, 0.5});
  body.velocity = {0, 0, -1};
  body.angular_velocity = {0, 0, 2};
  const BodyId id = scene.add_cloth(body);
  const std::vector<Vec3> x = scene.initial_positions(id), v = scene.initial_velocities(id);
  for (size_t i = 0; i < x.size(); ++i) {
    const Vec3 X = body.mesh.vertices[i];
    const Vec3 turned{std::cos(0.5) * X.x - std::sin(0.5) * X.y, std::sin(0.5) * X.x + std::cos(0.5) * X.y,
                      X.z};
    CHECK(norm(x[i] - turned - Vec3{1, 2, 3}) < 1e-15);
    CHECK(norm(v[i] - Vec3{-2 * turned.y, 2 * turned.x, -1}) < 1e-15);
  }
  body.initial_positions = body.mesh.vertices;
  for (Vec3& p : body.initial_positions) p *= 0.5;
  const BodyId squeezed = scene.add_cloth(body);
  CHECK(norm(scene.initial_positions(squeezed)[0] - (x[0] + Vec3{1, 2, 3}) * 0.5) < 1e-15);
}

TEST_CASE("contact: disabled pairs, bodies that do not move by forces, self-contact") {
  Scene scene;
  auto alone = cloth("alone");
  alone.self_contact = false;
  const BodyId c = scene.add_cloth(cloth("c")), d = scene.add_cloth(alone), s = scene.add_solid(solid("s")),
               r = scene.add_rigid(rigid("r")), f = scene.add_rigid(rigid("f", Motion::Fixed)),
               t = scene.add_rigid(rigid("t", Motion::Scripted));
  CHECK(scene.contact_enabled(c, c));
  CHECK(scene.contact_enabled(s, s));
  CHECK_FALSE(scene.contact_enabled(d, d));
  CHECK_FALSE(scene.contact_enabled(r, r));
  CHECK_FALSE(scene.contact_enabled(f, t));
  CHECK(scene.contact_enabled(r, f));
  CHECK(scene.contact_enabled(c, t));
  scene.disable_contact(t, c);
  CHECK_FALSE(scene.contact_enabled(c, t));
  scene.enable_contact(c, t);
  CHECK(scene.contact_enabled(t, c));
  scene.disable_contact(c, c);
  CHECK_FALSE(scene.contact_enabled(c, c));
}

TEST_CASE("pins keep their order and no vertex twice") {
  Scene scene;
  const BodyId c = scene.add_cloth(cloth()), r = scene.add_rigid(rigid());
  scene.pin(c, std::vector<int32_t>{5, 2, 5});
  scene.pin(c, std::vector<int32_t>{2, 0});
  CHECK(scene.pins(c).vertices == std::vector<int32_t>{5, 2, 0});
  CHECK_THROWS_AS(scene.pin(c, std::vector<int32_t>{1, 9}), InvalidArgument);
  CHECK(scene.pins(c).vertices.size() == 3);
  CHECK_THROWS_AS(scene.pin(r, std::vector<int32_t>{0}), InvalidArgument);
}

TEST_CASE("a contact distance that makes a mesh press on itself is warned about") {
  Scene scene;
  const BodyId c = scene.add_cloth(cloth());
  Settings settings;
  // Cells of 0.5 m: the height of a right isosceles triangle over its hypotenuse is 0.5 / sqrt(2).
  settings.contact.distance = 0.999 * 0.25 / std::sqrt(2.0);
  CHECK(check_contact_distances(scene, settings).empty());
  settings.contact.distance = 1.001 * 0.25 / std::sqrt(2.0);
  CHECK(check_contact_distances(scene, settings).size() == 1);
  scene.disable_contact(c, c);
  CHECK(check_contact_distances(scene, settings).empty());
}
