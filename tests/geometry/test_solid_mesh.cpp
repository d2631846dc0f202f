// Solid meshes: gradients in rest coordinates, volumes, lumping, boundaries, generation and refinement.
#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include <stark/base/error.h>
#include <stark/geometry/shapes.h>
#include <stark/geometry/solid_mesh.h>
#include <stark/geometry/topology.h>
#include <support/random_points.h>

using namespace stark;
using namespace stark::test;

namespace {

std::vector<SolidMesh> boxes() {
  const SolidMesh tets = make_tet_box({1, 2, 3}, {2, 1, 2}), hexes = make_hex_box({1, 2, 3}, {2, 1, 2});
  return {tets, to_quadratic(tets), hexes, to_quadratic(hexes)};
}

}  // namespace

TEST_CASE("boxes of every element type have the volume and the closed surface of the box") {
  for (const SolidMesh& mesh : boxes()) {
    double volume = 0.0, lumped = 0.0, enclosed = 0.0;
    for (const double v : compute_element_volumes(mesh)) volume += v;
    std::vector<double> parts(mesh.node_count());
    for (int64_t e = 0; e < mesh.element_count(); ++e) {
      lump_volume(mesh, e, parts);
      for (const double part : parts) {
        CHECK(part > 0.0);
        lumped += part;
      }
      CHECK(smallest_jacobian(mesh, e) > 0.0);
    }
    const std::vector<Index3> triangles = find_boundary_triangles(mesh);
    CHECK(is_closed(triangles));
    for (const Index3& t : triangles)
      enclosed += dot(mesh.vertices[t[0]], cross(mesh.vertices[t[1]], mesh.vertices[t[2]])) / 6.0;
    for (const double v : {volume, lumped, enclosed}) CHECK(v == doctest::Approx(6.0).epsilon(1e-12));
  }
}

TEST_CASE("diagonal scaling gives the known masses of a quadratic tetrahedron: 1/36 and 4/27") {
  const SolidMesh mesh = to_quadratic(TetMesh{{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}}, {{0, 1, 2, 3}}});
  std::vector<double> parts(10);
  lump_volume(mesh, 0, parts);
  for (int a = 0; a < 10; ++a)
    CHECK(parts[a] == doctest::Approx(a < 4 ? 1.0 / 36.0 : 4.0 / 27.0).epsilon(1e-12));
}

TEST_CASE("gradients in rest coordinates are those of linear fields, on distorted elements too") {
  RandomPoints random(3);
  for (SolidMesh mesh : boxes()) {
    for (Vec3& v : mesh.vertices) v += random.point() * 0.03;
    const Vec3 slope = random.point();
    std::vector<Vec3> G(mesh.node_count());
    for (int64_t e = 0; e < mesh.element_count(); ++e)
      for (const QuadraturePoint& p : reference_element(mesh.type).quadrature) {
        CHECK(rest_gradients(mesh, e, p.position, G) > 0.0);
        Vec3 found;
        for (int a = 0; a < mesh.node_count(); ++a)
          found += G[a] * dot(slope, mesh.vertices[mesh.element(e)[a]]);
        CHECK(max_abs(found - slope) < 1e-12);
      }
  }
}

TEST_CASE("refinement by order shares the new nodes and keeps the cells") {
  const SolidMesh hexes = to_quadratic(make_hex_box({1, 1, 1}, {3, 2, 1}));
  CHECK(hexes.vertices.size() == 7 * 5 * 3);
  CHECK(hexes.element_count() == 6);
  const TetMesh box = make_tet_box({1, 1, 1}, {1, 1, 1});
  const SolidMesh tets = to_quadratic(box);
  CHECK(tets.vertices.size() == box.vertices.size() + find_edges(box.tets).size());
  CHECK(find_edges(tets).size() == 2 * find_edges(box.tets).size());
  CHECK(find_edges(SolidMesh(box)) == find_edges(box.tets));
  CHECK(find_boundary_triangles(SolidMesh(box)) == find_boundary_triangles(box.tets));
  CHECK(to_quadratic(tets).vertices.size() == tets.vertices.size());
}

TEST_CASE("what refers to nothing is refused before it is used") {
  const auto refused = [](const SolidMesh& mesh, const char* message) {
    CHECK_THROWS_WITH_AS(check_indices(mesh), doctest::Contains(message), InvalidMesh);
  };
  SolidMesh mesh = make_hex_box({1, 1, 1}, {1, 1, 1});
  CHECK_NOTHROW(check_indices(mesh));
  refused({{}, mesh.type, mesh.elements}, "element 0 refers to vertex 0: indices must be in [0, 0)");
  mesh.vertices.push_back({0.0, 0.0, 0.0});
  mesh.embedding = {{0}, {{8, 8, 8}}, {CellFilling{}}};
  CHECK_NOTHROW(check_indices(mesh));
  for (const int32_t element : {1, -1}) {
    mesh.embedding.elements = {element};
    refused(mesh, ("embedded vertex 8 is in element " + std::to_string(element) + ": must be").c_str());
  }
  mesh.embedding.elements = {0};
  mesh.embedding.fillings.clear();
  refused(mesh, "0 fillings of 1 elements");
  mesh.embedding.elements.assign(10, 0);
  refused(mesh, "10 of 9 vertices are embedded");
}

TEST_CASE("an element that is turned inside out has a negative Jacobian") {
  SolidMesh mesh = to_quadratic(make_hex_box({1, 1, 1}, {1, 1, 1}));
  mesh.vertices[mesh.element(0)[26]] = {0.0, 0.0, 1.2};  // the centre outside of the cell
  CHECK(smallest_jacobian(mesh, 0) < 0.0);
}
