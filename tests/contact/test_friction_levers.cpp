// Where friction of corners of flat faces acts: inside the face, as far as it lies on the other one.
#include <doctest/doctest.h>

#include <stark/base/rotation.h>
#include <stark/contact/friction_stencil.h>

using namespace stark;

namespace {

/// Vertex 0 of the face 0 1 2, whose lever is site 7, over the square 3 4 5 6 of two triangles.
struct Pair {
  SurfaceMesh mesh{.vertex_count = 7, .edges = {}, .triangles = {{0, 2, 1}, {3, 4, 5}, {3, 5, 6}}};
  std::vector<Vec3> x{{0.1, 0.1, 0.5}, {0.9, 0.1, 0.5}, {0.1, 0.9, 0.5}, {0, 0, 0},
                      {1, 0, 0},       {1, 1, 0},       {0, 1, 0},       {0.3, 0.2, 0.5}};

  Contact contact() const {
    Contact contact;
    contact.key = {PairKind::PointTriangle, 0, 1};
    contact.point_count = 4;
    contact.sites = {0, 3, 4, 5};
    contact.weights = {1.0, -(1.0 - x[0].x), -(x[0].x - x[0].y), -x[0].y};
    contact.contact_distance = 1.0;
    return contact;
  }
  FrictionLevers levers() const { return {mesh, {{0, 0, 7}}, {0, 1, 1}}; }
  double part(const Vec3& normal = {0, 0, 1}) const {
    return levers().arm(mesh, contact(), 1, normal, x).part;
  }
};

}  // namespace

TEST_CASE("friction of a corner that lies flat acts at its lever") {
  Pair pair;
  CHECK(pair.part() == 1.0);
  const FrictionCarriers carriers(pair.mesh, std::vector<bool>(8, true), pair.levers());
  const FrictionStencil s = carriers.stencil(pair.mesh, pair.contact(), pair.x);
  CHECK(s.point_count == 4);
  CHECK(s.sites[0] == 7);
  CHECK(norm(s.shift - Vec3{0.2, 0.1, 0.0}) < 1e-15);
  Vec3 sum, torque;
  const Vec3 f{0.3, -0.4, 0.2};
  for (int p = 0; p < s.point_count; ++p) {
    const Vec3 force = f * s.weights[p] + s.facing * dot(s.slopes[p], f);
    sum += force;
    torque += cross(pair.x[s.sites[p]], force);
  }
  CHECK(norm(sum) < 1e-15);
  CHECK(norm(torque) < 1e-15);
}

TEST_CASE("it goes back to the corner as the site leaves the contact distance") {
  Pair pair;
  pair.x[7].z = 0.74;  // within half of the depth
  CHECK(pair.part() == 1.0);
  pair.x[7].z = 0.9;
  CHECK(pair.part() > 0.0);
  CHECK(pair.part() < 1.0);
  const FrictionCarriers carriers(pair.mesh, std::vector<bool>(8, true), pair.levers());
  CHECK(carriers.stencil(pair.mesh, pair.contact(), pair.x).point_count == 5);
  pair.x[7].z = 1.01;
  CHECK(pair.part() == 0.0);
}

TEST_CASE("it ends with the other face") {
  Pair pair;
  pair.x[7] = {0.3, -0.1, 0.5};  // half of the way is beside the square
  CHECK(pair.part() == doctest::Approx(0.5));
  pair.x[0] = {0.1, -0.05, 0.5};
  CHECK(pair.part() == 0.0);
  pair.x[7] = {0.3, 0.1, 0.5};  // over it, though the corner is not
  CHECK(pair.part() == 1.0);
}

TEST_CASE("faces that tilt have none") {
  Pair pair;
  for (const int k : {0, 1, 2, 7}) pair.x[k] = exp_rotation(Vec3{0.3, 0, 0}) * pair.x[k] + Vec3{0, 0, 0.2};
  CHECK(pair.part() == 0.0);
}
