// Plate elements: constant curvature has the energy of a plate on every mesh, in every direction.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <random>

#include <stark/geometry/shapes.h>
#include <stark/mechanics/plate_element.h>

using namespace stark;

namespace {

constexpr double kNu = 0.3;

/// Fold angle of a small deflection z over the plane at hinge h of an element, to first order.
double fold(const PlateElement& element, const std::vector<Vec3>& x, int h) {
  const auto& v = element.vertices;
  const std::array<int, 4> at = plate_hinge(h);
  const Vec3 &a = x[v[at[0]]], &b = x[v[at[1]]], &c = x[v[at[2]]], &d = x[v[at[3]]];
  const Vec3 e = b - a, n = cross(e, c - a), m = cross(d - a, e);
  return std::atan2(dot(cross(n, m), e) / norm(e), dot(n, m));
}

/// Bending energy of unit rigidity of the surface z(x, y) over a mesh.
template <typename Surface>
double energy(const TriangleMesh& mesh, const Surface& z) {
  std::vector<Vec3> x = mesh.vertices;
  for (Vec3& p : x) p.z = z(p.x, p.y);
  double total = 0.0;
  for (const PlateElement& element : find_plate_elements(mesh.vertices, mesh.triangles, kNu)) {
    std::array<double, 4> t{};
    for (int h = 0; h < element.hinge_count; ++h) t[h] = fold(element, x, h);
    size_t k = 0;
    for (int i = 0; i < 4; ++i)
      for (int j = i; j < 4; ++j, ++k) total += (i == j ? 0.5 : 1.0) * element.form[k] * t[i] * t[j];
  }
  return total;
}

TriangleMesh perturbed_grid(int cells, double amount) {
  TriangleMesh mesh = make_grid(1, 1, cells, cells);
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> noise(-amount / cells, amount / cells);
  for (Vec3& p : mesh.vertices)
    if (std::fabs(p.x) < 0.499 && std::fabs(p.y) < 0.499) p += Vec3{noise(random), noise(random), 0};
  return mesh;
}

/// Diagonals of the cells alternate.
TriangleMesh alternating_grid(int cells) {
  TriangleMesh mesh = make_grid(1, 1, cells, cells);
  const int n = cells + 1;
  mesh.triangles.clear();
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const int32_t a = j * n + i, b = a + 1, c = a + n, d = c + 1;
      if ((i + j) % 2 == 0) {
        mesh.triangles.push_back({a, b, d});
        mesh.triangles.push_back({a, d, c});
      } else {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({b, d, c});
      }
    }
  return mesh;
}

TriangleMesh equilateral(int cells) {
  TriangleMesh mesh = make_grid(1, 1, cells, cells);
  // Shear of the grid such that its diagonals are as long as its lines.
  for (Vec3& p : mesh.vertices) p = {p.x + 0.5 * p.y, std::sqrt(0.75) * p.y, 0};
  return mesh;
}

double area(const TriangleMesh& mesh) {
  double total = 0.0;
  for (const Index3& t : mesh.triangles)
    total += 0.5 * norm(cross(mesh.vertices[t[1]] - mesh.vertices[t[0]],
                              mesh.vertices[t[2]] - mesh.vertices[t[0]]));
  return total;
}

}  // namespace

namespace {

/// Largest relative error of the energy of cylinders in all directions, a bowl and a saddle of unit rigidity.
double worst_error(const TriangleMesh& mesh) {
  const double k = 1e-4;  // so flat that angles are linear
  const double plate = 0.5 * k * k * area(mesh);
  double worst = 0.0;
  for (const double degrees : {0.0, 22.5, 45.0, 67.5, 90.0, 120.0}) {
    const double c = std::cos(degrees * std::numbers::pi / 180),
                 s = std::sin(degrees * std::numbers::pi / 180);
    const double found =
        energy(mesh, [&](double x, double y) { return 0.5 * k * (c * x + s * y) * (c * x + s * y); });
    worst = std::max(worst, std::fabs(found / plate - 1.0));
  }
  const double bowl = energy(mesh, [&](double x, double y) { return 0.5 * k * (x * x + y * y); });
  const double saddle = energy(mesh, [&](double x, double y) { return k * x * y; });
  worst = std::max(worst, std::fabs(bowl / (plate * 2 * (1 + kNu)) - 1.0));
  return std::max(worst, std::fabs(saddle / (plate * 2 * (1 - kNu)) - 1.0));
}

}  // namespace

TEST_CASE("cylinders in every direction, bowls and saddles have the energy of a plate on every mesh") {
  CHECK(worst_error(make_grid(1, 1, 6, 6)) < 1e-6);
  CHECK(worst_error(equilateral(6)) < 1e-6);
  CHECK(worst_error(perturbed_grid(6, 0.25)) < 1e-6);
  // Of two triangles in a corner without any whole neighbour, the curvature cannot be told: the number of
  // corners stays while that of triangles grows.
  CHECK(worst_error(alternating_grid(12)) < 0.03);
  CHECK(worst_error(alternating_grid(24)) < 0.0075);
}

TEST_CASE("translations and rotations of the plane cost nothing, any fold something") {
  const TriangleMesh mesh = perturbed_grid(3, 0.2);
  CHECK(energy(mesh, [](double x, double y) { return 0.3 * x - 0.2 * y + 1.0; }) < 1e-25);
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vec3 bump = mesh.vertices[i];
    CHECK(energy(mesh, [&](double x, double y) { return x == bump.x && y == bump.y ? 1e-3 : 0.0; }) > 1e-8);
  }
}

TEST_CASE("every hinge has an element, in strips of one cell and around holes too") {
  for (const TriangleMesh& mesh : {make_grid(1, 0.1, 10, 1), make_grid(1, 1, 1, 1), make_grid(1, 1, 2, 2)}) {
    for (size_t i = 0; i < mesh.vertices.size(); ++i) {
      const Vec3 bump = mesh.vertices[i];
      CHECK(energy(mesh, [&](double x, double y) { return x == bump.x && y == bump.y ? 1e-3 : 0.0; }) > 1e-9);
    }
  }
  // A strip of one cell bent along its length, the hinges across it parallel to the axis.
  const double k = 1e-4;
  const TriangleMesh strip = make_grid(1, 0.1, 10, 1);
  const double found = energy(strip, [&](double x, double) { return 0.5 * k * x * x; });
  // Free to bend across: between the beam, 1 - nu^2, and the plate, 1.
  CHECK(found / (0.5 * k * k * 0.1) > 0.9);
  CHECK(found / (0.5 * k * k * 0.1) < 1.01);
}

TEST_CASE("rest angles are those of the mesh") {
  TriangleMesh tube;  // two cells folded by 0.2 rad
  tube.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, -std::cos(0.2), std::sin(0.2)}};
  tube.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 4, 1}};
  double largest = 0.0;
  for (const PlateElement& element : find_plate_elements(tube.vertices, tube.triangles, kNu))
    for (int h = 0; h < element.hinge_count; ++h)
      largest = std::max(largest, std::fabs(element.rest_angles[h]));
  CHECK(largest == doctest::Approx(0.2).epsilon(1e-12));
}
