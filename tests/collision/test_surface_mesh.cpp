// Checks of collision primitives.
#include <doctest/doctest.h>

#include <stark/base/error.h>
#include <stark/collision/surface_mesh.h>

using namespace stark;

TEST_CASE("collision meshes are checked with the primitive, the value and the remedy in the message") {
  SurfaceMesh mesh;
  mesh.vertex_count = 4;
  mesh.vertex_group = {0, 0, 0, 1};
  mesh.edges = {{0, 1}};
  mesh.edge_group = {0};
  mesh.triangles = {{0, 1, 2}};
  mesh.triangle_group = {0};
  mesh.points = {3};
  CHECK_NOTHROW(validate(mesh, 2));
  CHECK_THROWS_AS(validate(mesh, 1), InvalidMesh);
  const auto broken = [&](auto change) {
    SurfaceMesh copy = mesh;
    change(copy);
    CHECK_THROWS_AS(validate(copy, 2), InvalidMesh);
  };
  broken([](SurfaceMesh& m) { m.points[0] = 4; });
  broken([](SurfaceMesh& m) { m.edges[0][1] = -1; });
  broken([](SurfaceMesh& m) { m.edges[0][1] = 0; });
  broken([](SurfaceMesh& m) { m.triangles[0][2] = 0; });
  broken([](SurfaceMesh& m) { m.triangles[0][2] = 3; });
  broken([](SurfaceMesh& m) { m.triangle_group[0] = 1; });
  broken([](SurfaceMesh& m) { m.edge_group.clear(); });
  broken([](SurfaceMesh& m) { m.vertex_group.pop_back(); });
  broken([](SurfaceMesh& m) { m.vertex_group[3] = -1; });
  CHECK_THROWS_WITH_AS(validate(mesh, 1),
                       "collision mesh: group 1 is not in [0, 1), the range of the pair filter", InvalidMesh);
}
