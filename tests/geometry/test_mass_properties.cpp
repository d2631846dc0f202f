// Mass properties against closed forms and samples of the inside, invariance under rigid motion, eigen
// decomposition.
#include <doctest/doctest.h>

#include <algorithm>
#include <random>

#include <stark/geometry/intersection.h>
#include <stark/geometry/mass_properties.h>
#include <stark/geometry/shapes.h>

using namespace stark;

namespace {

Mat3 random_rotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const Vec3 a = normalized(Vec3{normal(random), normal(random), normal(random)});
  const Vec3 b = Vec3{normal(random), normal(random), normal(random)};
  const Vec3 c = normalized(cross(a, b));
  return Mat3::from_columns(a, cross(c, a), c);
}

double largest_difference(const Mat3& a, const Mat3& b) {
  double largest = 0.0;
  for (int k = 0; k < 9; ++k) largest = std::max(largest, std::fabs(a.m[k] - b.m[k]));
  return largest;
}

}  // namespace

TEST_CASE("solid box, moved and turned far away") {
  std::mt19937 random(1);
  const Vec3 size{0.1, 0.2, 0.3};
  const double density = 700.0, mass = density * 0.006;
  const Mat3 body =
      Mat3::diagonal({mass / 12 * (0.04 + 0.09), mass / 12 * (0.01 + 0.09), mass / 12 * (0.01 + 0.04)});
  for (int round = 0; round < 20; ++round) {
    const Mat3 rotation = random_rotation(random);
    const Vec3 shift{100.0, -50.0, 20.0};
    TriangleMesh mesh = make_box(size, 2);
    for (Vec3& v : mesh.vertices) v = rotation * v + shift;
    const MassProperties p = compute_solid_mass_properties(mesh.vertices, mesh.triangles, density);
    // Vertices carry errors of 1e-14 m from the shift; relative to 0.1 m that is 1e-13.
    CHECK(p.measure == doctest::Approx(0.006).epsilon(1e-11));
    CHECK(p.mass == doctest::Approx(mass).epsilon(1e-11));
    CHECK(norm(p.centre - shift) < 1e-12);
    CHECK(largest_difference(p.inertia, rotation * body * transpose(rotation)) < 1e-11 * mass);
  }
}

TEST_CASE("solid and hollow sphere converge to 2/5 and 2/3 m r^2") {
  const TriangleMesh mesh = make_icosphere(2.0, 5);
  const MassProperties solid = compute_solid_mass_properties(mesh.vertices, mesh.triangles, 3.0);
  const MassProperties shell = compute_shell_mass_properties(mesh.vertices, mesh.triangles, 3.0);
  for (int k = 0; k < 3; ++k) {
    // Discretisation error of an icosphere with 20,480 triangles is about 1e-3.
    CHECK(solid.inertia(k, k) == doctest::Approx(0.4 * solid.mass * 4.0).epsilon(2e-3));
    CHECK(shell.inertia(k, k) == doctest::Approx(2.0 / 3.0 * shell.mass * 4.0).epsilon(2e-3));
  }
}

TEST_CASE("square plate: exact shell inertia") {
  const TriangleMesh plate = make_grid(2.0, 2.0, 3, 5);
  const MassProperties p = compute_shell_mass_properties(plate.vertices, plate.triangles, 0.5);
  CHECK(p.measure == doctest::Approx(4.0).epsilon(1e-14));
  CHECK(largest_difference(p.inertia, Mat3::diagonal({2.0 / 3, 2.0 / 3, 4.0 / 3})) < 1e-14);
}

TEST_CASE("volume and inertia of shapes are those of random points inside") {
  std::mt19937 random(5);
  constexpr int kSamples = 20'000;
  for (const TriangleMesh& mesh : {make_box({1, 2, 3}, 2), make_icosphere(0.5, 2), make_cylinder(0.3, 1.0),
                                   make_capsule(0.3, 1.0), make_torus(1.0, 0.3)}) {
    Vec3 low = mesh.vertices[0], high = low;
    for (const Vec3& v : mesh.vertices)
      for (int i = 0; i < 3; ++i) {
        low[i] = std::min(low[i], v[i]);
        high[i] = std::max(high[i], v[i]);
      }
    int inside = 0;
    double r2 = 0.0;
    Mat3 second;
    for (int k = 0; k < kSamples; ++k) {
      Vec3 x;
      for (int i = 0; i < 3; ++i) x[i] = std::uniform_real_distribution<double>(low[i], high[i])(random);
      if (locate_point(x, mesh.vertices, mesh.triangles) != PointLocation::Inside) continue;
      ++inside;
      r2 += dot(x, x);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) second(i, j) += x[i] * x[j];
    }
    const Vec3 size = high - low;
    const double box = size.x * size.y * size.z, volume = box * inside / kSamples;
    const MassProperties p = compute_solid_mass_properties(mesh.vertices, mesh.triangles, 2.0);
    // Standard deviation of the estimate: sqrt(p (1 - p) / n) of the box, below 0.4 %; five of them.
    CHECK(std::fabs(p.measure - volume) < 0.02 * box);
    const Mat3 inertia = (Mat3::diagonal({r2, r2, r2}) - second) * (2.0 * volume / inside);
    const double largest = largest_difference(inertia, Mat3());
    CHECK(largest_difference(p.inertia, inertia) < 0.05 * largest);
  }
}

TEST_CASE("inward orientation shows as negative volume") {
  TriangleMesh mesh = make_box({1, 1, 1});
  for (Index3& t : mesh.triangles) std::swap(t[0], t[1]);
  CHECK(compute_solid_mass_properties(mesh.vertices, mesh.triangles, 1.0).measure == doctest::Approx(-1.0));
}

TEST_CASE("principal axes: residual, rotation, order; also for repeated and widely spread values") {
  std::mt19937 random(2);
  const std::vector<Vec3> spectra = {{1, 2, 3},      {1, 1, 2},  {1, 2, 2}, {1, 1, 1},
                                     {1e-9, 1, 1e9}, {-1, 0, 1}, {0, 0, 0}};
  for (const Vec3& spectrum : spectra) {
    for (int round = 0; round < 50; ++round) {
      const Mat3 rotation = random_rotation(random);
      Mat3 a = rotation * Mat3::diagonal(spectrum) * transpose(rotation);
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < i; ++j) a(i, j) = a(j, i);
      }
      const PrincipalAxes p = compute_principal_axes(a);
      const double scale = std::max(1e-300, std::fabs(spectrum.z));
      CHECK(std::fabs(p.values.x - spectrum.x) < 1e-14 * scale * 10);
      CHECK(std::fabs(p.values.y - spectrum.y) < 1e-14 * scale * 10);
      CHECK(std::fabs(p.values.z - spectrum.z) < 1e-14 * scale * 10);
      CHECK(p.values.x <= p.values.y);
      CHECK(p.values.y <= p.values.z);
      CHECK(largest_difference(transpose(p.axes) * p.axes, Mat3::identity()) < 1e-14);
      CHECK(determinant(p.axes) == doctest::Approx(1.0).epsilon(1e-14));
      CHECK(largest_difference(p.axes * Mat3::diagonal(p.values) * transpose(p.axes), a) <
            1e-14 * scale * 10);
    }
  }
}

TEST_CASE("principal axes of a diagonal matrix are the coordinate axes") {
  const PrincipalAxes p = compute_principal_axes(Mat3::diagonal({1, 2, 3}));
  CHECK(p.axes == Mat3::identity());
  CHECK(p.values == Vec3{1, 2, 3});
}
