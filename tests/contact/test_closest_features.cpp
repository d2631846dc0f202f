// One contact of a point with each place of a surface: flat, convex and concave ones, borders, rods, names.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include <stark/contact/closest_features.h>
#include <stark/geometry/distance.h>
#include <stark/geometry/shapes.h>
#include <support/collision_scenes.h>
#include <support/contact_potentials.h>
#include <support/random_points.h>

using namespace stark;
using namespace stark::test;

namespace {

constexpr double kReach = 0.3;

/// A particle as vertex 0 and group 0 against a surface, all pairs being candidates.
struct PointAgainst {
  explicit PointAgainst(const TriangleMesh& mesh) {
    builder.add_particles({{}});
    builder.add_mesh(mesh);
    prepare();
  }
  explicit PointAgainst(const std::vector<Vec3>& rod) {
    builder.add_particles({{}});
    builder.add_rod(rod);
    prepare();
  }
  void prepare() {
    geometry.mesh = &builder.surface;
    geometry.group_distance = {0.5 * kReach, 0.5 * kReach};
    geometry.edge_squared_length.assign(builder.surface.edges.size(), 1.0);
    cells = SurfaceCells(builder.surface, {});
    for (int32_t t = 0; t < static_cast<int32_t>(builder.surface.triangles.size()); ++t)
      list[PairKind::PointTriangle].push_back({0, t});
    if (builder.surface.triangles.empty())
      for (int32_t e = 0; e < static_cast<int32_t>(builder.surface.edges.size()); ++e)
        list[PairKind::PointEdge].push_back({0, e});
  }
  std::vector<Contact> at(const Vec3& p, std::vector<PairKey> names = {}) {
    builder.x[0] = p;
    std::vector<Contact> contacts;
    find_contacts(geometry, list, builder.x, pool, contacts);
    return merge_by_feature(geometry, cells, names, builder.x, contacts, pool);
  }
  double energy(const Vec3& p) {
    double sum = 0.0;
    for (const Contact& c : at(p)) sum += c.multiplicity * barrier(c.distance, kReach);
    return sum;
  }
  SceneBuilder builder;
  ContactGeometry geometry;
  SurfaceCells cells;
  CandidateList list;
  ThreadPool pool{1};
};

/// Two squares with a common edge along y, both rising to the sides by `slope`.
TriangleMesh folded(double slope) {
  TriangleMesh mesh = make_grid(2.0, 1.0, 2, 1);
  for (Vec3& v : mesh.vertices) v.z = slope * std::fabs(v.x);
  return mesh;
}

}  // namespace

TEST_CASE("above a flat sheet there is one contact, wherever the point is and however the mesh") {
  PointAgainst sheet(make_grid(1.0, 1.0, 7, 5));
  RandomPoints random(1);
  for (int k = 0; k < 300; ++k) {
    const Vec3 r = random.point();
    const Vec3 p{0.49 * r.x, 0.49 * r.y, 0.15 + 0.1 * r.z};
    const std::vector<Contact> contacts = sheet.at(p);
    REQUIRE(contacts.size() == 1);
    CHECK(contacts[0].multiplicity == 1);
    CHECK(contacts[0].distance == doctest::Approx(p.z));
  }
  for (size_t v = 1; v < sheet.builder.x.size(); ++v) {  // above each vertex, as in a stack of sheets
    Vec3 p = sheet.builder.x[v];
    p.z = 0.1;
    const std::vector<Contact> contacts = sheet.at(p);
    REQUIRE(contacts.size() == 1);
    CHECK(contacts[0].multiplicity == 1);
  }
}

TEST_CASE("beside the border and over a ridge there is one contact, too") {
  PointAgainst sheet(make_grid(1.0, 1.0, 4, 4)), ridge(folded(-1.0));
  for (const Vec3& p : {Vec3{0.6, 0.1, 0.1}, Vec3{0.6, 0.6, 0.1}, Vec3{0.52, 0.25, 0.0}})
    CHECK(sheet.energy(p) ==
          doctest::Approx(
              barrier(std::hypot(std::fmax(p.x - 0.5, 0.0), std::fmax(p.y - 0.5, 0.0), p.z), kReach)));
  const std::vector<Contact> contacts = ridge.at({0.01, 0.1, 0.2});
  REQUIRE(contacts.size() == 1);
  CHECK(contacts[0].kind == StencilKind::PointEdge);
  CHECK(contacts[0].multiplicity == 1);
}

TEST_CASE("in a valley both sides push, and what they have in common is taken away") {
  PointAgainst valley(folded(0.5));
  const std::vector<Contact> contacts = valley.at({0.0, 0.1, 0.15});
  int sum = 0, negative = 0;
  for (const Contact& c : contacts) {
    sum += c.multiplicity;
    negative += c.multiplicity < 0;
  }
  CHECK(sum == 1);
  CHECK(negative == 1);
}

TEST_CASE("the energy has no jumps as a point moves across triangles, ridges, valleys and borders") {
  for (const double slope : {-1.0, -0.1, 0.0, 0.1, 1.0}) {
    PointAgainst fold(folded(slope));
    double before = fold.energy({-1.2, -0.7, 0.12}), largest = 0.0, highest = 0.0;
    constexpr int kSteps = 4000;
    for (int k = 1; k <= kSteps; ++k) {
      const double s = static_cast<double>(k) / kSteps;
      const Vec3 p{-1.2 + 2.4 * s, -0.7 + 1.3 * s, 0.12 + slope * std::fabs(-1.2 + 2.4 * s)};
      const double now = fold.energy(p);
      largest = std::fmax(largest, std::fabs(now - before));
      highest = std::fmax(highest, now);
      before = now;
    }
    CHECK(highest > 0.01);
    CHECK(largest < 0.01 * highest);  // 4000 steps over 20 contact distances
  }
}

TEST_CASE("a point has one contact with a rod") {
  PointAgainst rod(std::vector<Vec3>{{-1, 0, 0}, {0, 0, 0}, {1, 0.1, 0}, {2, 0, 0}});
  for (const Vec3& p : {Vec3{-0.5, 0, 0.1}, Vec3{0, 0, 0.1}, Vec3{0.01, -0.1, 0.1}, Vec3{1, 0.2, 0}})
    CHECK(rod.at(p).size() == 1);
}

TEST_CASE("a contact keeps its name while its point slides to the next triangle") {
  PointAgainst sheet(make_grid(1.0, 1.0, 4, 4));
  const PairKey name = sheet.at({0.05, 0.1, 0.1})[0].key, next = sheet.at({0.1, 0.05, 0.1})[0].key;
  REQUIRE(name != next);
  CHECK(sheet.at({0.1, 0.05, 0.1}, {name})[0].key == name);
  CHECK(sheet.at({-0.45, -0.45, 0.1}, {name})[0].key != name);  // far away
}

TEST_CASE("pairs without a part that moves have no contact") {
  PointAgainst sheet(make_grid(1.0, 1.0, 4, 4));
  sheet.geometry.prescribed.assign(sheet.builder.x.size(), 1);
  CHECK(sheet.at({0.1, 0.05, 0.1}).empty());
  sheet.geometry.prescribed[0] = 0;
  CHECK(sheet.at({0.1, 0.05, 0.1}).size() == 1);
}

TEST_CASE("many contacts merge in the same way on any number of threads") {
  SceneBuilder builder;
  builder.add_mesh(make_grid(1.0, 1.0, 16, 16));
  builder.add_mesh(make_grid(1.0, 1.0, 13, 13));
  RandomPoints random(3);
  for (Vec3& p : builder.x) p += random.point() * 0.01;
  const int32_t lower = 17 * 17;  // vertices
  ContactGeometry geometry;
  geometry.mesh = &builder.surface;
  geometry.group_distance = {0.04, 0.04};
  geometry.edge_squared_length.assign(builder.surface.edges.size(), 1.0);
  CandidateList list;
  for (int32_t v = 0; v < lower; ++v)
    for (int32_t t = 0; t < static_cast<int32_t>(builder.surface.triangles.size()); ++t)
      if (builder.surface.triangles[t][0] >= lower) list[PairKind::PointTriangle].push_back({v, t});
  const SurfaceCells cells(builder.surface, {});
  ThreadPool alone(1), several(3);
  std::vector<Contact> near;
  find_contacts(geometry, list, builder.x, several, near);
  REQUIRE(near.size() > 1500);  // several tasks
  std::vector<PairKey> names;
  for (size_t c = 0; c < near.size(); c += 3) names.push_back(near[c].key);
  const auto one = merge_by_feature(geometry, cells, names, builder.x, near, alone);
  const auto other = merge_by_feature(geometry, cells, names, builder.x, near, several);
  REQUIRE(one.size() == other.size());
  for (size_t c = 0; c < one.size(); ++c) {
    CHECK(one[c].key == other[c].key);
    CHECK(one[c].sites == other[c].sites);
    CHECK(one[c].multiplicity == other[c].multiplicity);
  }
  // As if there were only those of one point.
  std::vector<Contact> of_point;
  for (size_t c = 0; c < near.size(); ++c)
    if (near[c].key.first == lower / 2) of_point.push_back(near[c]);
  REQUIRE(!of_point.empty());
  for (const Contact& alone_contact : merge_by_feature(geometry, cells, names, builder.x, of_point, alone)) {
    const auto found = std::ranges::find(one, alone_contact.key, &Contact::key);
    REQUIRE(found != one.end());
    CHECK(found->multiplicity == alone_contact.multiplicity);
  }
}
