// Shapes: counts, closedness, orientation, volumes against closed forms.
#include <doctest/doctest.h>

#include <numbers>

#include <stark/base/error.h>
#include <stark/geometry/mass_properties.h>
#include <stark/geometry/shapes.h>
#include <stark/geometry/topology.h>

using namespace stark;

namespace {

double volume(const TriangleMesh& mesh) {
  return compute_solid_mass_properties(mesh.vertices, mesh.triangles, 1.0).measure;
}

void check_closed_surface(const TriangleMesh& mesh, int euler_characteristic) {
  CHECK_NOTHROW(validate(mesh, "shape"));
  CHECK(is_closed(mesh.triangles));
  CHECK(is_orientation_consistent(mesh.triangles));
  CHECK(volume(mesh) > 0.0);
  const int v = static_cast<int>(mesh.vertices.size()), f = static_cast<int>(mesh.triangles.size());
  const int e = static_cast<int>(find_edges(mesh.triangles).size());
  CHECK(v - e + f == euler_characteristic);
  CHECK(find_used_vertices(mesh.triangles).size() == mesh.vertices.size());
}

}  // namespace

TEST_CASE("grid: counts, extent, +z normals, antisymmetric coordinates") {
  const TriangleMesh grid = make_grid(0.4, 0.2, 32, 10);
  CHECK(grid.vertices.size() == 33 * 11);
  CHECK(grid.triangles.size() == 2 * 32 * 10);
  CHECK(grid.vertices.front() == Vec3{-0.2, -0.1, 0.0});
  CHECK(grid.vertices.back() == Vec3{0.2, 0.1, 0.0});
  for (const Index3& t : grid.triangles) {
    const Vec3 n =
        cross(grid.vertices[t[1]] - grid.vertices[t[0]], grid.vertices[t[2]] - grid.vertices[t[0]]);
    CHECK(n.z == doctest::Approx(0.0125 * 0.02).epsilon(1e-12));
  }
  for (int k = 0; k < 33 * 11; ++k) CHECK(grid.vertices[k] == -grid.vertices[33 * 11 - 1 - k]);
}

TEST_CASE("closed shapes") {
  check_closed_surface(make_box({1, 2, 3}), 2);
  check_closed_surface(make_box({1, 2, 3}, 4), 2);
  check_closed_surface(make_icosphere(0.5, 3), 2);
  check_closed_surface(make_cylinder(0.5, 2.0, 16, 3), 2);
  check_closed_surface(make_capsule(0.5, 2.0, 16, 4), 2);
  check_closed_surface(make_torus(1.0, 0.25), 0);
}

TEST_CASE("volumes and sizes") {
  constexpr double kPi = std::numbers::pi;
  CHECK(make_box({1, 1, 1}).vertices.size() == 8);
  CHECK(make_box({1, 1, 1}).triangles.size() == 12);
  CHECK(volume(make_box({1, 2, 3}, 3)) == doctest::Approx(6.0).epsilon(1e-14));
  CHECK(make_icosphere(1.0, 3).vertices.size() == 642);
  for (const Vec3& v : make_icosphere(0.25, 3).vertices)
    CHECK(norm(v) == doctest::Approx(0.25).epsilon(1e-15));
  // Inscribed polyhedra converge from below with the square of the edge length.
  const double sphere = 4.0 / 3.0 * kPi;
  CHECK((sphere - volume(make_icosphere(1.0, 4))) / (sphere - volume(make_icosphere(1.0, 5))) ==
        doctest::Approx(4.0).epsilon(0.02));
  const double area_16 = 0.5 * 16 * std::sin(2 * kPi / 16);  // regular 16-gon of radius 1
  CHECK(volume(make_cylinder(1.0, 2.0, 16)) == doctest::Approx(2.0 * area_16).epsilon(1e-13));
  CHECK(volume(make_capsule(1.0, 2.0, 256, 64)) == doctest::Approx(2.0 * kPi + sphere).epsilon(1e-3));
  CHECK(volume(make_torus(1.0, 0.25, 256, 256)) == doctest::Approx(2.0 * kPi * kPi * 0.0625).epsilon(1e-3));
}

TEST_CASE("tet box: node and tet counts of the benchmark, volume, conformity") {
  const TetMesh box = make_tet_box({0.2, 0.2, 0.2}, {20, 20, 20});
  CHECK(box.vertices.size() == 17261);
  CHECK(box.tets.size() == 12 * 8000);
  double sum = 0.0;
  for (const double v : compute_tet_volumes(box.vertices, box.tets)) {
    CHECK(v == doctest::Approx(1e-6 / 12).epsilon(1e-9));
    sum += v;
  }
  CHECK(sum == doctest::Approx(0.008).epsilon(1e-12));
  // Conforming: no interior face is left over, so the boundary is exactly the faces of the box.
  CHECK(find_boundary_triangles(box.tets).size() == 6 * 20 * 20 * 2);
}

TEST_CASE("bad parameters are refused") {
  CHECK_THROWS_AS(make_grid(0.0, 1.0, 2, 2), InvalidArgument);
  CHECK_THROWS_WITH_AS(make_grid(-1e-9, 1.0, 2, 2), doctest::Contains("size_x is -1e-09 m"), InvalidArgument);
  CHECK_THROWS_AS(make_grid(1.0, 1.0, 0, 2), InvalidArgument);
  CHECK_THROWS_AS(make_box({1.0, -1.0, 1.0}), InvalidArgument);
  CHECK_THROWS_AS(make_icosphere(NAN, 2), InvalidArgument);
  CHECK_THROWS_AS(make_torus(1.0, 1.5), InvalidArgument);
  CHECK_THROWS_AS(make_cylinder(1.0, 1.0, 2), InvalidArgument);
  CHECK_THROWS_AS(make_tet_box({1, 1, 1}, {1, 0, 1}), InvalidArgument);
}
