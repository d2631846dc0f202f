// Surfaces in lattices: volumes, centres, second moments, which cells there are, errors.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include <stark/base/error.h>
#include <stark/geometry/embedding.h>
#include <stark/geometry/lattice.h>
#include <stark/geometry/shapes.h>

using namespace stark;

namespace {

struct Mass {
  double volume = 0.0;
  Vec3 centre;
};

Mass lumped(const SolidMesh& mesh) {
  Mass mass;
  std::vector<double> parts(mesh.node_count());
  for (int64_t e = 0; e < mesh.element_count(); ++e) {
    lump_volume(mesh, e, parts);
    for (int a = 0; a < mesh.node_count(); ++a) {
      CHECK(parts[a] > 0.0);
      mass.volume += parts[a];
      mass.centre += mesh.vertices[mesh.element(e)[a]] * parts[a];
    }
  }
  mass.centre *= 1.0 / mass.volume;
  return mass;
}

/// Box of some triangles, away from the origin.
TriangleMesh shifted_box() {
  TriangleMesh box = make_box({1.0, 0.7, 0.43});
  for (Vec3& v : box.vertices) v += {0.1, 0.2, 0.3};
  return box;
}

}  // namespace

TEST_CASE("volume and centre of mass of bodies that are not aligned with the lattice") {
  const TriangleMesh ball = make_icosphere(0.5, 4), box = shifted_box();
  for (const bool quadratic : {false, true})
    for (const double size : {0.13, 0.3}) {
      const Mass of_ball = lumped(make_lattice(ball, size, quadratic));
      double exact = 0.0;
      for (const auto& [i, j, k] : ball.triangles)
        exact += dot(ball.vertices[i], cross(ball.vertices[j], ball.vertices[k])) / 6.0;
      CHECK(of_ball.volume == doctest::Approx(exact).epsilon(1e-12));
      CHECK(norm(of_ball.centre) < 0.01 * size);
      const Mass of_box = lumped(make_lattice(box, size, quadratic));
      CHECK(of_box.volume == doctest::Approx(1.0 * 0.7 * 0.43).epsilon(1e-12));
      CHECK(norm(of_box.centre - Vec3{0.1, 0.2, 0.3}) < 0.01 * size);
    }
}

TEST_CASE("second moments of a body not aligned with the lattice are exact but for the samples") {
  // Of the ball: 1/5 r^2 V in each direction.
  const TriangleMesh ball = make_icosphere(0.5, 5);
  std::vector<double> errors;
  for (const double size : {0.22, 0.11}) {
    const SolidMesh mesh = make_lattice(ball, size);
    double moment = 0.0, volume = 0.0;
    for (int64_t e = 0; e < mesh.element_count(); ++e) {
      const CellFilling& f = mesh.embedding.fillings[e];
      const double corner = mesh.vertices[mesh.element(e)[0]].x;
      moment +=
          f.part() * (corner * corner + 2.0 * corner * size * f.mean().x + size * size * f.mean_square().x);
      volume += f.part();
    }
    errors.push_back(std::fabs(moment / volume / (0.05) - 1.0));
  }
  // Of 1,024 points in each cell that is cut, and of the polyhedron, which is 2e-4 lighter far out than a
  // ball.
  for (const double error : errors) CHECK(error < 2e-3);
}

TEST_CASE("embedded vertices are in their cells, and cells that hold nothing are left out") {
  const TriangleMesh ball = make_icosphere(0.5, 3);
  const SolidMesh mesh = make_lattice(ball, 0.1);
  CHECK(mesh.element_count() < 1000);  // a ball fills half of its box; some cells at the border are cut
  CHECK(mesh.element_count() > 520);
  CHECK(mesh.vertices.size() - mesh.first_embedded() == ball.vertices.size());
  for (size_t k = 0; k < ball.vertices.size(); ++k) {
    CHECK(mesh.vertices[mesh.first_embedded() + k] == ball.vertices[k]);
    const Vec3 xi = find_reference_position(mesh, mesh.embedding.elements[k], ball.vertices[k]);
    CHECK(max_abs(xi - Vec3{0.5, 0.5, 0.5}) < 0.5 + 1e-9);
  }
  CHECK(find_boundary_triangles(mesh) == mesh.embedding.triangles);
}

TEST_CASE("surfaces with holes and overlaps have an inside by their winding number") {
  TriangleMesh ball = make_icosphere(0.5, 4);
  const double whole = lumped(make_lattice(ball, 0.1)).volume;
  TriangleMesh open = ball;
  std::erase_if(open.triangles, [&](const Index3& t) { return open.vertices[t[0]].z > 0.47; });
  std::vector<Vec3> used;
  std::vector<int32_t> number(open.vertices.size(), -1);
  for (Index3& t : open.triangles)
    for (int32_t& v : t) {
      if (number[v] < 0) {
        number[v] = static_cast<int32_t>(used.size());
        used.push_back(open.vertices[v]);
      }
      v = number[v];
    }
  open.vertices = used;
  CHECK(lumped(make_lattice(open, 0.1)).volume == doctest::Approx(whole).epsilon(0.02));
  // Two balls in one another are one.
  const auto count = static_cast<int32_t>(ball.vertices.size());
  TriangleMesh two = ball;
  for (const Vec3& v : ball.vertices) two.vertices.push_back(v * 0.999);
  for (const auto& [i, j, k] : ball.triangles) two.triangles.push_back({i + count, j + count, k + count});
  CHECK(lumped(make_lattice(two, 0.1)).volume == doctest::Approx(whole).epsilon(0.02));
}

TEST_CASE("what is no body in a lattice is refused") {
  const TriangleMesh ball = make_icosphere(0.5, 2);
  CHECK_THROWS_AS(make_lattice(ball, 0.0), InvalidArgument);
  CHECK_THROWS_AS(make_lattice(ball, std::numeric_limits<double>::quiet_NaN()), InvalidArgument);
  CHECK_THROWS_AS(make_lattice(ball, 1e-4), InvalidArgument);
  CHECK_THROWS_AS(make_lattice({}, 0.1), InvalidMesh);
  CHECK_THROWS_AS(make_lattice(make_grid(1.0, 1.0, 2, 2), 0.1), InvalidMesh);  // encloses nothing
  TriangleMesh wrong = ball;
  for (Index3& t : wrong.triangles) std::swap(t[0], t[1]);
  CHECK_THROWS_WITH_AS(make_lattice(wrong, 0.1), doctest::Contains("inwards"), InvalidMesh);
  wrong = ball;
  wrong.vertices[3].y = std::numeric_limits<double>::infinity();
  CHECK_THROWS_AS(make_lattice(wrong, 0.1), InvalidMesh);
  wrong = ball;
  wrong.vertices.push_back({});
  CHECK_THROWS_AS(make_lattice(wrong, 0.1), InvalidMesh);
}
