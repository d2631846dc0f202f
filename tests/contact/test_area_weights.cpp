// Areas of contacts: shares of meshes, of flat faces, of rods; which mesh integrates; pairs of edges.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include <stark/contact/area_weights.h>
#include <stark/geometry/flat_faces.h>
#include <stark/geometry/shapes.h>
#include <support/collision_scenes.h>

using namespace stark;
using namespace stark::test;

namespace {

constexpr Vec3 kUp{0, 0, 1};

Contact of_point(int32_t point, int32_t group_a, int32_t group_b) {
  Contact contact;
  contact.key = {PairKind::PointTriangle, point, 0};
  contact.group_a = group_a;
  contact.group_b = group_b;
  return contact;
}

/// A mesh as group 0 against a square of 100 m as group 1, so that all of it is integrated on the mesh.
struct OnGround {
  OnGround(const TriangleMesh& mesh, bool is_sheet, bool has_faces) {
    builder.add_mesh(mesh);
    const auto count = static_cast<int32_t>(mesh.vertices.size());
    builder.add_mesh(make_grid(100.0, 100.0, 1, 1));
    FlatFaces faces =
        has_faces ? find_flat_faces(mesh.vertices, mesh.triangles) : separate_faces(mesh.triangles);
    const auto first = static_cast<int32_t>(mesh.triangles.size());
    faces.patch.insert(faces.patch.end(), {first, first + 1});
    weights = {builder.surface, builder.x, faces.patch, std::vector<uint8_t>{is_sheet, 1},
               std::vector<double>{0.01, 0.01}};
    for (int32_t v = 0; v < count; ++v) {
      const double area = weights.area(builder.surface, of_point(v, 0, 1), kUp, builder.x);
      areas.push_back(area);
    }
  }
  double total(double z) const {
    double sum = 0.0;
    for (size_t v = 0; v < areas.size(); ++v)
      if (std::fabs(builder.x[v].z - z) < 1e-12) sum += areas[v];
    return sum;
  }
  SceneBuilder builder;
  AreaWeights weights;
  std::vector<double> areas;
};

}  // namespace

TEST_CASE("vertices share the area of a sheet") {
  const OnGround sheet(make_grid(0.6, 0.4, 3, 5), true, false);
  CHECK(sheet.total(0.0) == doctest::Approx(0.24));
}

TEST_CASE("corners of a box share the face that they stand on, whatever its triangulation") {
  for (const int subdivisions : {1, 4}) {
    const OnGround box(make_box({0.2, 0.3, 0.1}, subdivisions), false, true);
    CHECK(box.total(-0.05) == doctest::Approx(0.06));
  }
  const OnGround box(make_box({0.2, 0.2, 0.2}), false, true);
  CHECK(box.areas[0] == doctest::Approx(0.01));
}

TEST_CASE("vertices of a soft box do not count its sides") {
  const OnGround box(make_box({0.2, 0.2, 0.2}, 4), false, false);
  CHECK(box.total(-0.1) == doctest::Approx(0.04));
}

TEST_CASE("a ball has the area of its vertices where they touch") {
  const OnGround ball(make_icosphere(0.1, 3), false, true);
  double lowest = 1.0, area = 0.0;
  for (size_t v = 0; v < ball.areas.size(); ++v)
    if (ball.builder.x[v].z < lowest) {
      lowest = ball.builder.x[v].z;
      area = ball.areas[v];
    }
  const double mean = 4.0 * 3.14159265 * 0.01 / static_cast<double>(ball.areas.size());
  CHECK(area == doctest::Approx(mean).epsilon(0.25));
}

TEST_CASE("the finer mesh integrates, equal ones half each") {
  const auto part = [](int cells_a, int cells_b) {
    SceneBuilder builder;
    builder.add_mesh(make_grid(1.0, 1.0, cells_a, cells_a));
    builder.add_mesh(make_grid(1.0, 1.0, cells_b, cells_b));
    const AreaWeights weights(builder.surface, builder.x, {}, std::vector<uint8_t>{1, 1},
                              std::vector<double>{0.01, 0.01});
    double sum = 0.0;
    for (int32_t v = 0; v < (cells_a + 1) * (cells_a + 1); ++v)
      sum += weights.area(builder.surface, of_point(v, 0, 1), kUp, builder.x);
    return sum;
  };
  CHECK(part(4, 4) == doctest::Approx(0.5));
  CHECK(part(8, 4) == doctest::Approx(1.0).epsilon(0.005));
  CHECK(part(4, 8) < 0.03);  // vertices of the border keep a part
  CHECK(part(5, 4) + part(4, 5) == doctest::Approx(1.0));
}

TEST_CASE("pairs of edges have what their edges stand for, and a range by how sharp they are") {
  struct Pair {
    double area = 0.0, range = 0.0;  ///< of the pair with the largest range
  };
  const auto widest = [](const TriangleMesh& mesh, bool is_sheet) {
    SceneBuilder builder;
    builder.add_mesh(mesh);
    builder.add_mesh(mesh, {0, 0, 1});
    std::vector<int32_t> patch;
    for (int k = 0; k < 2; ++k)
      for (const int32_t p : find_flat_faces(mesh.vertices, mesh.triangles).patch)
        patch.push_back(p + k * static_cast<int32_t>(mesh.triangles.size()));
    if (is_sheet) patch.clear();
    const AreaWeights weights(builder.surface, builder.x, patch, std::vector<uint8_t>(2, is_sheet),
                              std::vector<double>{0.01, 0.01});
    const EdgeRanges ranges = weights.edge_ranges(builder.surface);
    Pair found;
    const auto count = static_cast<int32_t>(builder.surface.edges.size()) / 2;
    for (int32_t e = 0; e < count; ++e) {
      Contact contact;
      contact.key = {PairKind::EdgeEdge, e, e + count};
      contact.group_b = 1;
      const double range = ranges(e, e + count);
      if (range > found.range) found = {weights.area(builder.surface, contact, kUp, builder.x), range};
    }
    return found;
  };
  const Pair borders = widest(make_grid(1.0, 1.0, 1, 1), true);
  CHECK(borders.area == doctest::Approx(1.0 / 6.0));
  CHECK(borders.range == doctest::Approx(std::pow(0.1, 0.5 * 0.5)));
  const Pair corners = widest(make_box({1, 1, 1}), false);
  CHECK(corners.area == doctest::Approx(0.25));
  CHECK(corners.range == 1.0);
}

TEST_CASE("a rod has its length times its diameter") {
  SceneBuilder builder;
  builder.add_rod({{0, 0, 0}, {0.1, 0, 0}, {0.3, 0, 0}});
  builder.add_mesh(make_grid(100.0, 100.0, 1, 1));
  const AreaWeights weights(builder.surface, builder.x, {}, std::vector<uint8_t>{1, 1},
                            std::vector<double>{0.005, 0.01});
  double sum = 0.0;
  for (int32_t v = 0; v < 3; ++v) sum += weights.area(builder.surface, of_point(v, 0, 1), kUp, builder.x);
  CHECK(sum == doctest::Approx(0.3 * 0.01));
}

TEST_CASE("a rod across an edge has an area that no normal changes") {
  // One that followed the normal from step to step would give energy to a rod that runs over edges.
  SceneBuilder builder;
  builder.add_mesh(make_box({1, 1, 1}));
  builder.add_rod({{-1, 0, 0.6}, {1, 0, 0.6}});
  const AreaWeights weights(builder.surface, builder.x, {}, std::vector<uint8_t>{0, 1},
                            std::vector<double>{0.005, 0.01});
  const auto rod = static_cast<int32_t>(builder.surface.edges.size()) - 1;
  double least = 1.0, most = 0.0;
  for (int32_t e = 0; e < rod; ++e) {
    Contact contact;
    contact.key = {PairKind::EdgeEdge, e, rod};
    contact.group_b = 1;
    CHECK_FALSE(weights.is_directed(contact));
    const double area = weights.area(builder.surface, contact, kUp, builder.x);
    CHECK(weights.area(builder.surface, contact, normalized(Vec3{1, 2, 3}), builder.x) == area);
    least = std::min(least, area);
    most = std::max(most, area);
  }
  // Each half of a face gives a third to an edge: at a right angle to each other, or both of one face.
  CHECK(least == doctest::Approx(std::sqrt(2.0) / 6.0));
  CHECK(most == doctest::Approx(1.0 / 3.0));
  Contact between;
  between.key = {PairKind::EdgeEdge, 0, 1};
  CHECK(weights.is_directed(between));
}
