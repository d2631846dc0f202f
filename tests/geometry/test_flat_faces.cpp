// Flat faces: inner edges and vertices of triangulated polyhedra, convex faces; distances to what is left.
#include <doctest/doctest.h>

#include <set>

#include <stark/base/rotation.h>
#include <stark/geometry/flat_faces.h>
#include <stark/geometry/shapes.h>
#include <stark/geometry/topology.h>

using namespace stark;

namespace {

FlatFaces of(const TriangleMesh& mesh) { return find_flat_faces(mesh.vertices, mesh.triangles); }

size_t face_count(const FlatFaces& faces) {
  return std::set<int32_t>(faces.face.begin(), faces.face.end()).size();
}

/// A flat mesh of the unit cells (i, j) that are not in the list.
TriangleMesh plate(int width, int height, const std::set<std::pair<int, int>>& missing) {
  TriangleMesh mesh;
  for (int i = 0; i <= width; ++i)
    for (int j = 0; j <= height; ++j) mesh.vertices.push_back({double(i), double(j), 0.0});
  const auto id = [&](int i, int j) { return i * (height + 1) + j; };
  for (int i = 0; i < width; ++i)
    for (int j = 0; j < height; ++j) {
      if (missing.contains({i, j})) continue;
      mesh.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      mesh.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  return mesh;
}

}  // namespace

TEST_CASE("a box has twelve edges and six convex faces, however it is turned") {
  TriangleMesh box = make_box({1, 2, 3});
  const Mat3 R = exp_rotation({0.3, -1.1, 0.7});
  for (Vec3& v : box.vertices) v = R * v + Vec3{5, -7, 2};
  const FlatFaces faces = of(box);
  CHECK(faces.edges.size() == 12);
  CHECK(faces.inner_vertices.empty());
  CHECK(face_count(faces) == 6);
}

TEST_CASE("a grid is one face with its border") {
  const TriangleMesh grid = make_grid(1.0, 2.0, 7, 5);
  const FlatFaces faces = of(grid);
  CHECK(faces.edges.size() == 2 * (7 + 5));
  CHECK(faces.inner_vertices.size() == 6 * 4);
  CHECK(face_count(faces) == 1);
}

TEST_CASE("what is bent by more than rounding has no inner edges") {
  TriangleMesh grid = make_grid(1.0, 1.0, 2, 2);
  grid.vertices[4].z = 1e-6;
  CHECK(of(grid).edges.size() == find_edges(std::span<const Index3>(grid.triangles)).size());
  const TriangleMesh ball = make_icosphere(1.0, 2);
  CHECK(of(ball).edges.size() == find_edges(std::span<const Index3>(ball.triangles)).size());
  CHECK(face_count(of(ball)) == ball.triangles.size());
}

TEST_CASE("flat faces that are not convex lose inner edges but keep their triangles") {
  const FlatFaces corner = of(plate(2, 2, {{1, 1}}));
  CHECK(corner.edges.size() == 8);
  CHECK(corner.inner_vertices.empty());
  CHECK(face_count(corner) == 6);
  const FlatFaces hole = of(plate(3, 3, {{1, 1}}));
  CHECK(hole.edges.size() == 16);
  CHECK(face_count(hole) == 16);
}

TEST_CASE("folded and overlapping sheets are faces of their own") {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.9, 0}};
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}};  // back over itself about the edge 0-1
  CHECK(of(mesh).edges.size() == 5);
  CHECK(face_count(of(mesh)) == 2);
}
