// Where friction of corners of flat faces acts: inside the face, as far as it lies on the other one.
#include <doctest/doctest.h>

#include <cmath>

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

namespace {

/// The square 0 1 2 3 of a body above the square 4 5 6 7 of another one, with a lever for each corner.
struct Squares {
  SurfaceMesh mesh{.vertex_count = 12,
                   .edges = {{1, 2}, {6, 7}},
                   .triangles = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}},
                   .vertex_group = {0, 0, 0, 0, 1, 1, 1, 1, -1, -1, -1, -1}};
  std::vector<Vec3> x{{0, 0, 0.5}, {1, 0, 0.5}, {1, 1, 0.5}, {0, 1, 0.5}, {0, 0, 0},     {1, 0, 0},
                      {1, 1, 0},   {0, 1, 0},   {0, 0, 0},   {0, 0, 0},   {0.5, 0.5, 0}, {0.5, 0.5, 0}};

  void move(const Vec3& by) {
    for (int k = 0; k < 4; ++k) x[k] += by;
  }
  FrictionCarriers carriers() const {
    std::vector<LeverSite> sites;
    for (int32_t k = 0; k < 8; ++k) sites.push_back({k, k < 4 ? 0 : 2, k < 4 ? 10 : 11});
    return FrictionCarriers(mesh, std::vector<bool>(12, true), {mesh, std::move(sites), {0, 0, 2, 2}});
  }
  /// Corner 2 over corner 6.
  static Contact corners() {
    Contact contact;
    contact.key = {PairKind::PointTriangle, 2, 2};
    contact.point_count = 2;
    contact.sites = {2, 6, 0, 0};
    contact.weights = {1.0, -1.0, 0.0, 0.0};
    contact.group_b = 1;
    contact.contact_distance = 1.0;
    return contact;
  }
  /// Edge 1 2, at x = 0.8, over edge 6 7.
  static Contact edges() {
    Contact contact;
    contact.key = {PairKind::EdgeEdge, 0, 1};
    contact.point_count = 4;
    contact.side_a_count = 2;
    contact.sites = {1, 2, 6, 7};
    contact.weights = {0.1, 0.9, -0.8, -0.2};
    contact.group_b = 1;
    contact.contact_distance = 1.0;
    return contact;
  }
};

void check_balance(const FrictionStencil& s, std::span<const Vec3> x) {
  Vec3 sum, torque;
  const Vec3 f{0.3, -0.4, 0.2};
  for (int p = 0; p < s.point_count; ++p) {
    const Vec3 force = f * s.weights[p] + s.facing * dot(s.slopes[p], f);
    sum += force;
    torque += cross(x[s.sites[p]], force);
  }
  CHECK(norm(sum) < 1e-15);
  CHECK(norm(torque) < 1e-15);
}

}  // namespace

TEST_CASE("corners over corners and edges over edges have friction inside of what both faces share") {
  Squares squares;
  const double part = (std::sqrt(2.0) + std::asinh(1.0)) / 6.0 / std::sqrt(0.5);
  const FrictionStencil equal = squares.carriers().stencil(squares.mesh, Squares::corners(), squares.x);
  CHECK(equal.point_count == 6);
  CHECK(norm(equal.shift - Vec3{-0.5, -0.5, 0} * (1.0 - part)) < 1e-14);
  check_balance(equal, squares.x);

  squares.move({-0.2, 0.1, 0});  // both share the rectangle from 0 to 0.8 and from 0.1 to 1
  const FrictionStencil crossing = squares.carriers().stencil(squares.mesh, Squares::edges(), squares.x);
  CHECK(crossing.point_count == 6);
  const Vec3 to_centre = Vec3{0.4, 0.55, 0.5} - Vec3{0.8, 1.0, 0.5};
  CHECK(norm(cross(crossing.shift, to_centre)) < 1e-15);
  CHECK(norm(crossing.shift) / norm(to_centre) == doctest::Approx(1.0 - part).epsilon(0.01));
  check_balance(crossing, squares.x);
  // Kept within a step, however the bodies move.
  squares.move({0.05, 0, 0});
  const FrictionStencil kept =
      squares.carriers().stencil(squares.mesh, Squares::edges(), squares.x, crossing.arm);
  CHECK(norm(kept.shift - crossing.shift) < 1e-14);
}

TEST_CASE("a place that is kept has the opposite motion where the sides of the contact change their names") {
  Squares squares;
  squares.move({-0.2, 0.1, 0});
  const FrictionCarriers carriers = squares.carriers();
  const FrictionStencil found = carriers.stencil(squares.mesh, Squares::edges(), squares.x);
  Contact turned = Squares::edges();
  std::swap(turned.group_a, turned.group_b);
  turned.sites = {6, 7, 1, 2};
  turned.weights = {0.8, 0.2, -0.1, -0.9};
  const FrictionStencil kept = carriers.stencil(squares.mesh, turned, squares.x, found.arm);
  check_balance(kept, squares.x);
  CHECK(norm(kept.shift - found.shift) < 1e-14);
  const std::vector<Vec3> before = squares.x;
  squares.move({0.01, 0.02, 0});
  CHECK(norm(found.motion(squares.x, before) - Vec3{0.01, 0.02, 0}) < 1e-15);
  CHECK(norm(kept.motion(squares.x, before) + Vec3{0.01, 0.02, 0}) < 1e-15);
}

TEST_CASE("where less than half of the smaller face lies on the other, friction stays at the corners") {
  Squares squares;
  squares.move({-0.6, 0.1, 0});
  Contact contact = Squares::edges();
  contact.weights = {0.1, 0.9, -0.4, -0.6};
  CHECK(norm(squares.carriers().stencil(squares.mesh, contact, squares.x).shift) == 0.0);
}

TEST_CASE("arms are found by pair, and by point on another triangle of the same flat face") {
  const std::vector<int32_t> patch{0, 1, 1, 3};
  LeverArms arms;
  arms.append({PairKind::PointTriangle, 0, 1}, {.site = 7, .part = 0.5});
  arms.append({PairKind::PointTriangle, 2, 3}, {.site = 8, .part = 1.0});
  arms.append({PairKind::EdgeEdge, 0, 2}, {.site = 9, .part = 0.2});
  const auto site = [&](PairKind kind, int32_t first, int32_t second) {
    const std::optional<LeverArm> arm = arms.find({kind, first, second}, patch);
    return arm ? arm->site : -1;
  };
  CHECK(site(PairKind::PointTriangle, 0, 1) == 7);
  CHECK(site(PairKind::PointTriangle, 0, 2) == 7);
  CHECK(site(PairKind::PointTriangle, 0, 3) == -1);
  CHECK(site(PairKind::PointTriangle, 2, 3) == 8);
  CHECK(site(PairKind::PointTriangle, 2, 1) == -1);
  CHECK(site(PairKind::EdgeEdge, 0, 2) == 9);
  CHECK(site(PairKind::EdgeEdge, 0, 1) == -1);
  arms.clear();
  CHECK(site(PairKind::PointTriangle, 0, 1) == -1);
}
