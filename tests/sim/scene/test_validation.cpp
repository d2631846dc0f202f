// The checks of meshes at their thresholds, and the smallest height of a triangle.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include <stark/base/error.h>
#include <stark/base/rotation.h>
#include <stark/geometry/shapes.h>
#include <stark/sim/scene/validation.h>

using namespace stark;

namespace {

TriangleMesh triangle_of_height(double height) {
  return {.vertices = {{0, 0, 0}, {1, 0, 0}, {0.5, height, 0}}, .triangles = {{0, 1, 2}}};
}

}  // namespace

TEST_CASE("thin triangles are refused by their shape, not by their size") {
  std::vector<std::string> warnings;
  CHECK_NOTHROW(check_cloth_mesh("a", triangle_of_height(1.1e-6), warnings));
  CHECK_THROWS_AS(check_cloth_mesh("a", triangle_of_height(0.9e-6), warnings), InvalidMesh);
  CHECK_NOTHROW(check_rigid_mesh("a", triangle_of_height(1e-9), warnings));
  CHECK_THROWS_AS(check_rigid_mesh("a", triangle_of_height(0.0), warnings), InvalidMesh);
  TriangleMesh tiny = triangle_of_height(0.5);
  for (Vec3& v : tiny.vertices) v *= 1e-7;
  CHECK_NOTHROW(check_cloth_mesh("a", tiny, warnings));
  CHECK(warnings.empty());
}

TEST_CASE("elements that are inverted at a quadrature point are refused") {
  SolidMesh mesh = make_hex_box({1, 1, 1}, {2, 1, 1});
  CHECK_NOTHROW(check_solid_mesh("a", mesh));
  CHECK_NOTHROW(check_solid_mesh("a", to_quadratic(mesh)));
  std::swap(mesh.elements[8], mesh.elements[10]);  // not the order of VTK any more
  try {
    check_solid_mesh("a", mesh);
    FAIL("accepted");
  } catch (const InvalidMesh& error) {
    CHECK(std::string(error.what()).find("hexahedron 1 has a Jacobian of -") != std::string::npos);
  }
  SolidMesh tets = to_quadratic(make_tet_box({1, 1, 1}, {1, 1, 1}));
  tets.vertices[static_cast<size_t>(tets.element(3)[7])] += Vec3{0.6, 0.6, 0.6};
  CHECK_THROWS_AS(check_solid_mesh("a", tets), InvalidMesh);
}

TEST_CASE("flat and inverted tetrahedra are told apart") {
  TetMesh mesh{.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2, 1e-3}}, .tets = {{0, 1, 2, 3}}};
  CHECK_NOTHROW(check_solid_mesh("a", mesh));
  const auto message = [&] {
    try {
      check_solid_mesh("a", mesh);
    } catch (const InvalidMesh& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  mesh.vertices[3].z = -1e-3;
  CHECK(message().find("inverted") != std::string::npos);
  mesh.vertices[3].z = 1e-7;
  CHECK(message().find("degenerate") != std::string::npos);
}

TEST_CASE("closed meshes pass, open and inconsistent ones do not") {
  TriangleMesh box = make_box({1, 1, 1});
  CHECK_NOTHROW(check_closed("a", box, "a test"));
  TriangleMesh open = box;
  open.triangles.pop_back();
  CHECK_THROWS_AS(check_closed("a", open, "a test"), InvalidMesh);
  TriangleMesh twisted = box;
  std::swap(twisted.triangles[0][0], twisted.triangles[0][1]);
  CHECK_THROWS_AS(check_closed("a", twisted, "a test"), InvalidMesh);
}

TEST_CASE("vectors are refused that are not finite, or whose lengths overflow") {
  check_finite("body 'a'", "velocity", {1e149, -1e149, 0}, "m/s");
  for (const double bad : {1e150, -1e300, std::numeric_limits<double>::infinity(), std::nan("")})
    CHECK_THROWS_WITH_AS(check_finite("body 'a'", "velocity", {0, bad, 0}, "m/s"),
                         doctest::Contains("body 'a': velocity = (0, "), InvalidArgument);
}

TEST_CASE("rotations within rounding pass, scalings and reflections do not") {
  CHECK_NOTHROW(check_rotation("a", exp_rotation({1, 2, 3})));
  CHECK_THROWS_AS(check_rotation("a", exp_rotation({1, 2, 3}) * (1.0 + 1e-5)), InvalidArgument);
  CHECK_THROWS_AS(check_rotation("a", Mat3::diagonal({1, 1, -1})), InvalidArgument);
  CHECK_THROWS_AS(check_rotation("a", Mat3::diagonal({1, std::nan(""), 1})), InvalidArgument);
}

TEST_CASE("the smallest height is that over the longest edge") {
  const TriangleMesh mesh = triangle_of_height(0.1);
  const SmallestHeight smallest = find_smallest_height(mesh.vertices, mesh.triangles);
  CHECK(smallest.height == doctest::Approx(0.1).epsilon(1e-14));
  CHECK(smallest.triangle == 0);
}
