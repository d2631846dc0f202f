// Connectivity: counts by Euler's formula and hand-made meshes.
#include <doctest/doctest.h>

#include <algorithm>
#include <set>

#include <stark/base/error.h>
#include <stark/geometry/mass_properties.h>
#include <stark/geometry/shapes.h>
#include <stark/geometry/topology.h>

using namespace stark;

TEST_CASE("two triangles: edges, hinge orientation, boundary") {
  const std::vector<Index3> triangles = {{0, 1, 2}, {2, 1, 3}};
  CHECK(find_edges(triangles) == std::vector<Index2>{{0, 1}, {0, 2}, {1, 2}, {1, 3}, {2, 3}});
  // The shared edge runs 1 -> 2 in the first triangle, whose apex is 0.
  CHECK(find_hinges(triangles) == std::vector<Index4>{{1, 2, 0, 3}});
  CHECK(find_boundary_edges(triangles) == std::vector<Index2>{{0, 1}, {2, 0}, {1, 3}, {3, 2}});
  CHECK_FALSE(is_closed(triangles));
  CHECK(is_orientation_consistent(triangles));
  CHECK_FALSE(is_orientation_consistent(std::vector<Index3>{{0, 1, 2}, {1, 2, 3}}));
}

TEST_CASE("hinge winding: (v0, v1, v2) repeats a triangle up to rotation, (v1, v0, v3) the other") {
  const TriangleMesh torus = make_torus(1.0, 0.3, 7, 5);
  std::set<Index3> rotations;
  for (const Index3& t : torus.triangles) {
    rotations.insert({t[0], t[1], t[2]});
    rotations.insert({t[1], t[2], t[0]});
    rotations.insert({t[2], t[0], t[1]});
  }
  const auto hinges = find_hinges(torus.triangles);
  CHECK(hinges.size() == torus.triangles.size() * 3 / 2);
  for (const Index4& h : hinges) {
    CHECK(rotations.count({h[0], h[1], h[2]}) == 1);
    CHECK(rotations.count({h[1], h[0], h[3]}) == 1);
  }
}

TEST_CASE("edges with three triangles give three hinges and are neither closed nor consistent") {
  const std::vector<Index3> fan = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};
  CHECK(find_hinges(fan).size() == 3);
  CHECK_FALSE(is_closed(fan));
  CHECK_FALSE(is_orientation_consistent(fan));
}

TEST_CASE("edge triangles list each triangle three times") {
  const TriangleMesh grid = make_grid(1.0, 1.0, 3, 2);
  const EdgeTriangles adjacency = find_edge_triangles(grid.triangles);
  CHECK(adjacency.edges == find_edges(grid.triangles));
  CHECK(adjacency.triangles.size() == 3 * grid.triangles.size());
  for (size_t e = 0; e < adjacency.edges.size(); ++e) {
    for (int32_t k = adjacency.offsets[e]; k < adjacency.offsets[e + 1]; ++k) {
      const Index3& t = grid.triangles[adjacency.triangles[k]];
      for (const int32_t v : adjacency.edges[e]) CHECK(std::find(t.begin(), t.end(), v) != t.end());
    }
  }
}

TEST_CASE("boundary of a tet mesh is closed, outward and has the surface of the box") {
  const TetMesh box = make_tet_box({1.0, 2.0, 3.0}, {3, 2, 4});
  const auto surface = find_boundary_triangles(box.tets);
  CHECK(surface.size() == 2 * 2 * (3 * 2 + 2 * 4 + 3 * 4));
  CHECK(is_closed(surface));
  CHECK(is_orientation_consistent(surface));
  double area = 0.0;
  for (const double a : compute_triangle_areas(box.vertices, surface)) area += a;
  CHECK(area == doctest::Approx(22.0).epsilon(1e-13));
  CHECK(compute_solid_mass_properties(box.vertices, surface, 1.0).measure == doctest::Approx(6.0));
  for (const Index3& t : surface) {
    const Vec3 &a = box.vertices[t[0]], &b = box.vertices[t[1]], &c = box.vertices[t[2]];
    CHECK(dot(cross(b - a, c - a), a + b + c) > 0.0);
  }
}

TEST_CASE("components, used vertices, areas") {
  std::vector<Index3> triangles = {{5, 3, 4}, {0, 2, 6}, {4, 5, 7}};
  CHECK(find_connected_components(8, triangles) == std::vector<int32_t>{0, 1, 0, 2, 2, 2, 0, 2});
  CHECK(find_used_vertices(triangles) == std::vector<int32_t>{0, 2, 3, 4, 5, 6, 7});
  const TriangleMesh grid = make_grid(2.0, 1.0, 4, 2);
  double vertex_sum = 0.0, edge_sum = 0.0;
  for (const double a : compute_vertex_areas(grid.vertices, grid.triangles)) vertex_sum += a;
  for (const double a : compute_edge_areas(grid.vertices, grid.triangles, find_edges(grid.triangles)))
    edge_sum += a;
  CHECK(vertex_sum == doctest::Approx(2.0).epsilon(1e-14));
  CHECK(edge_sum == doctest::Approx(2.0).epsilon(1e-14));
}

TEST_CASE("validation names the mesh and the element") {
  TriangleMesh mesh = make_grid(1.0, 1.0, 1, 1);
  CHECK_NOTHROW(validate(mesh, "cloth"));
  mesh.triangles.push_back({0, 1, 9});
  CHECK_THROWS_WITH_AS(
      validate(mesh, "cloth"),
      "cloth: triangle 2 uses vertex 9, but there are 4 vertices (0-based); check the index array",
      InvalidMesh);
  mesh.triangles.back() = {0, 1, 1};
  CHECK_THROWS_AS(validate(mesh, "cloth"), InvalidMesh);
  mesh.triangles.pop_back();
  mesh.vertices[1].y = NAN;
  CHECK_THROWS_AS(validate(mesh, "cloth"), InvalidMesh);
  TetMesh tets = make_tet_box({1, 1, 1}, {1, 1, 1});
  CHECK_NOTHROW(validate(tets, "soft"));
  std::swap(tets.tets[3][0], tets.tets[3][1]);
  CHECK_THROWS_AS(validate(tets, "soft"), InvalidMesh);
}
