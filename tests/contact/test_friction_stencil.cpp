// Where friction acts: forces of a pair have no sum and no torque, and common rotations are no slip.
#include <doctest/doctest.h>

#include <cmath>

#include <stark/base/rotation.h>
#include <stark/contact/friction_stencil.h>
#include <support/random_points.h>

using namespace stark;
using namespace stark::test;

namespace {

/// Vertex 0 against triangle 1 2 3; edge 4 5 of triangle 4 5 6 against edge 1 2.
const SurfaceMesh& mesh() {
  static const SurfaceMesh mesh{
      .vertex_count = 7, .edges = {{4, 5}, {1, 2}}, .triangles = {{1, 2, 3}, {4, 5, 6}}};
  return mesh;
}

FrictionCarriers carriers(bool rigid) { return FrictionCarriers(mesh(), std::vector<bool>(7, rigid)); }

/// Points of two triangles that are some way apart, and the closest points' weights (any will do).
std::vector<Vec3> random_sites(RandomPoints& random) {
  std::vector<Vec3> x;
  for (int i = 0; i < 7; ++i) x.push_back(random.point());
  return x;
}

Contact point_triangle(int count) {
  Contact contact;
  contact.key = {PairKind::PointTriangle, 0, 0};
  contact.point_count = static_cast<int8_t>(count);
  contact.sites = {0, 1, 2, 3};
  contact.weights = count == 2   ? std::array<double, 4>{1, -1, 0, 0}
                    : count == 3 ? std::array<double, 4>{1, -0.4, -0.6, 0}
                                 : std::array<double, 4>{1, -0.2, -0.3, -0.5};
  return contact;
}

Contact edge_edge() {
  Contact contact;
  contact.key = {PairKind::EdgeEdge, 0, 1};
  contact.point_count = 4;
  contact.side_a_count = 2;
  contact.sites = {4, 5, 1, 2};
  contact.weights = {0.3, 0.7, -0.6, -0.4};
  return contact;
}

Contact swapped(Contact contact) {
  contact.sites = {1, 2, 4, 5};
  contact.weights = {0.6, 0.4, -0.3, -0.7};
  return contact;
}

std::vector<Contact> all_contacts() {
  return {point_triangle(2), point_triangle(3), point_triangle(4), edge_edge(), swapped(edge_edge())};
}

}  // namespace

TEST_CASE("a force at the point of friction has neither sum nor torque") {
  RandomPoints random(3);
  for (int trial = 0; trial < 50; ++trial)
    for (const Contact& contact : all_contacts()) {
      const std::vector<Vec3> x = random_sites(random);
      const FrictionStencil s = carriers(true).stencil(mesh(), contact, x);
      const Vec3 f = random.point();
      Vec3 sum, torque;
      double scale = 0.0;
      for (int p = 0; p < s.point_count; ++p) {
        const Vec3 force = f * s.weights[p] + s.facing * dot(s.slopes[p], f);
        sum += force;
        torque += cross(x[s.sites[p]], force);
        scale += norm(force);
      }
      CHECK(norm(sum) < 1e-13 * scale);
      CHECK(norm(torque) < 1e-13 * scale);
    }
}

TEST_CASE(
    "the point of friction is the closest one of the side that is carried, whatever the sides are called") {
  RandomPoints random(5);
  for (const Contact& contact : all_contacts()) {
    const std::vector<Vec3> x = random_sites(random);
    const FrictionStencil s = carriers(true).stencil(mesh(), contact, x), turned = s.swapped();
    REQUIRE(s.is_carried());
    Vec3 a, b;  // closest points of both sides
    for (int p = 0; p < contact.point_count; ++p)
      (p < contact.side_a_count ? a : b) += x[contact.sites[p]] * std::fabs(contact.weights[p]);
    CHECK(std::min(norm(s.point(x) - a), norm(s.point(x) - b)) < 1e-14);
    CHECK(norm(turned.point(x) - s.point(x)) == 0.0);
    const std::vector<Vec3> still(x.size());
    CHECK(norm(turned.motion(x, still) + s.motion(x, still)) == 0.0);
  }
}

TEST_CASE("common motions are no slip, and the motion is that of the closest points without turning") {
  RandomPoints random(4);
  for (int trial = 0; trial < 50; ++trial)
    for (const Contact& contact : all_contacts()) {
      const std::vector<Vec3> x = random_sites(random);
      const FrictionStencil s = carriers(true).stencil(mesh(), contact, x);
      const Vec3 shift = random.point(), turn = random.point() * 1e-6;
      std::vector<Vec3> moved;
      for (const Vec3& p : x) moved.push_back(exp_rotation(turn) * p + shift);
      double scale = 1.0;
      for (int p = 0; p < s.point_count; ++p) scale += std::fabs(s.weights[p]) + norm(s.slopes[p]);
      CHECK(norm(s.motion(moved, x)) < 1e-11 * scale);
      // One side alone, shifted.
      std::vector<Vec3> apart = x;
      Vec3 expected;
      for (int p = 0; p < contact.point_count; ++p) {
        const bool is_first = contact.sites[p] == 0 || contact.sites[p] > 3;
        if (is_first) expected += shift * contact.weights[p];
      }
      for (const int32_t site : {0, 4, 5, 6}) apart[site] += shift;
      CHECK(norm(s.motion(apart, x) - expected) < 1e-13 * scale);
    }
}

TEST_CASE("about axes in the plane of the triangle, rotations by any angle are no tangential slip") {
  const std::vector<Vec3> x{{0.2, 0.3, 0.05}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {}, {}, {}};
  const FrictionStencil s = carriers(false).stencil(mesh(), point_triangle(4), x);
  for (const double angle : {0.1, 0.7, 2.0}) {
    std::vector<Vec3> before;
    for (const Vec3& p : x) before.push_back(exp_rotation(Vec3{angle, 0, 0}) * p);
    const Vec3 u = s.motion(x, before);
    CHECK(std::hypot(u.x, u.y) < 1e-14);
  }
}

TEST_CASE("edges without a rigid body, and flat triangles, have the closest points as they are") {
  RandomPoints random(5);
  std::vector<Vec3> x = random_sites(random);
  const FrictionStencil soft = carriers(false).stencil(mesh(), edge_edge(), x);
  CHECK(soft.point_count == 4);
  for (int p = 0; p < 4; ++p) {
    CHECK(soft.weights[p] == edge_edge().weights[p]);
    CHECK(soft.slopes[p] == Vec3{});
  }
  x[3] = x[1] * 0.5 + x[2] * 0.5;
  CHECK(carriers(true).stencil(mesh(), point_triangle(2), x).point_count == 2);
}

TEST_CASE("friction of rods that cross has neither sum nor torque, and common motions are no slip") {
  // Two rods of two edges each; the middle vertex of either may be what is touched.
  const SurfaceMesh rods{.vertex_count = 6, .edges = {{0, 1}, {1, 2}, {3, 4}, {4, 5}}, .triangles = {}};
  const FrictionCarriers carriers(rods);
  RandomPoints random(6);
  for (int trial = 0; trial < 50; ++trial) {
    const Vec3 n = normalized(random.point());
    const auto across = [&] { return normalized(cross(n, random.point())); };
    const Vec3 e_a = across(), e_b = across();
    if (norm(cross(e_a, e_b)) < 0.4) continue;
    const Vec3 at = random.point(), other = at - n * 0.3;
    const std::vector<Vec3> x{at - e_a, at, at + e_a, other - e_b, other, other + e_b};
    Contact edges{.key = {PairKind::EdgeEdge, 0, 3}, .point_count = 4, .side_a_count = 2};
    edges.sites = {0, 1, 4, 5};
    edges.weights = {0.0, 1.0, -1.0, 0.0};
    Contact vertices{.key = {PairKind::EdgeEdge, 0, 3}, .point_count = 2, .side_a_count = 1};
    vertices.sites = {1, 4};
    vertices.weights = {1.0, -1.0};
    for (const Contact& contact : {edges, vertices}) {
      const FrictionStencil s = carriers.stencil(rods, contact, x);
      REQUIRE(s.turns());
      CHECK(!s.is_carried());
      const Vec3 f = random.point();
      Vec3 sum, torque;
      for (int p = 0; p < s.point_count; ++p) {
        const Vec3 force = f * s.weights[p] + s.facing * dot(s.slopes[p], f);
        sum += force;
        torque += cross(x[s.sites[p]], force);
      }
      CHECK(norm(sum) < 1e-13);
      CHECK(norm(torque) < 1e-12);
      const Vec3 shift = random.point(), turn = random.point() * 1e-6;
      std::vector<Vec3> moved;
      for (const Vec3& p : x) moved.push_back(exp_rotation(turn) * p + shift);
      CHECK(norm(s.motion(moved, x)) < 1e-10);
    }
  }
}
