// Frames that turn with bodies: steady turns, angular momentum, what does not turn, and points on a line.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include <stark/base/rotation.h>
#include <stark/mechanics/turning_frame.h>
#include <support/random_points.h>

using namespace stark;
using namespace stark::test;

namespace {

struct Points {
  std::vector<double> masses;
  std::vector<Vec3> x, v;
};

Points cloud(int count, const Vec3& spin, double shake) {
  RandomPoints random(7);
  Points points;
  Vec3 centre;
  double mass = 0.0;
  for (int i = 0; i < count; ++i) {
    points.masses.push_back(0.1 + 0.05 * (i % 3));
    points.x.push_back(random.point() + Vec3{3, 4, 5});
    centre += points.x.back() * points.masses.back();
    mass += points.masses.back();
  }
  centre = centre * (1.0 / mass);
  for (const Vec3& x : points.x)
    points.v.push_back(Vec3{1, -2, 0.5} + cross(spin, x - centre) + random.point() * shake);
  return points;
}

Vec3 angular_momentum(const Points& points, const std::vector<Vec3>& x, const std::vector<Vec3>& v) {
  Vec3 centre, velocity, sum;
  double mass = 0.0;
  for (size_t i = 0; i < x.size(); ++i) {
    centre += x[i] * points.masses[i];
    velocity += v[i] * points.masses[i];
    mass += points.masses[i];
  }
  for (size_t i = 0; i < x.size(); ++i)
    sum += cross(x[i] - centre * (1.0 / mass), v[i] - velocity * (1.0 / mass)) * points.masses[i];
  return sum;
}

std::vector<Vec3> free_places(const TurningFrame& frame, const Points& points, double h) {
  std::vector<Vec3> places;
  for (size_t i = 0; i < points.x.size(); ++i)
    places.push_back(free_place(frame, points.x[i], points.v[i], h));
  return places;
}

}  // namespace

TEST_CASE("forces towards the axis that balance the centrifugal ones leave a steady turn, for any step") {
  const Vec3 spin{3, -8, 5}, velocity{1, -2, 0.5};
  Points points;  // corners of a cube: all axes are principal ones
  for (int i = 0; i < 8; ++i) {
    const Vec3 r{i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0};
    points.masses.push_back(0.1);
    points.x.push_back(r + Vec3{3, 4, 5});
    points.v.push_back(velocity + cross(spin, r));
  }
  for (const double h : {1e-3, 1e-2, 0.05}) {
    const TurningFrame frame = turning_frame(points.masses, points.x, points.v, h);
    CHECK(norm(frame.spin - spin) < 1e-6 * norm(spin));
    const std::vector<Vec3> x_free = free_places(frame, points, h);
    std::vector<Vec3> x_end, v(points.x.size());
    for (const Vec3& x : points.x)
      x_end.push_back(frame.centre + frame.velocity * h + exp_rotation(spin * h) * (x - frame.centre));
    for (size_t i = 0; i < x_end.size(); ++i) {
      const Vec3 r = x_end[i] - frame.centre - frame.velocity * h;
      const Vec3 balance = cross(spin, cross(spin, r)) * (h * h);  // h^2 f/m
      CHECK(norm(x_free[i] + balance - x_end[i]) < 1e-6 * norm(r));
    }
    end_velocities(frame, points.masses, points.x, x_free, x_end, h, v);
    for (size_t i = 0; i < x_end.size(); ++i)
      CHECK(norm(v[i] - frame.velocity - cross(spin, x_end[i] - frame.centre - frame.velocity * h)) < 1e-5);
  }
}

TEST_CASE("angular momentum changes by the impulse of the torques alone, momentum by that of the forces") {
  const Points points = cloud(20, {4, 1, -6}, 0.8);
  const double h = 0.02;
  const TurningFrame frame = turning_frame(points.masses, points.x, points.v, h);
  REQUIRE(norm(frame.spin) > 1.0);
  const std::vector<Vec3> x_free = free_places(frame, points, h);
  RandomPoints random(3);
  std::vector<Vec3> x_end, v(points.x.size());
  for (const Vec3& x : x_free) x_end.push_back(x + random.point() * 0.05);
  end_velocities(frame, points.masses, points.x, x_free, x_end, h, v);
  Vec3 centre, impulse, before, after;
  double mass = 0.0;
  for (size_t i = 0; i < v.size(); ++i) {
    centre += x_end[i] * points.masses[i];
    mass += points.masses[i];
    impulse += (x_end[i] - x_free[i]) * (points.masses[i] / h);
    before += points.v[i] * points.masses[i];
    after += v[i] * points.masses[i];
  }
  CHECK(norm(after - before - impulse) < 1e-12 * norm(before));
  Vec3 expected = angular_momentum(points, points.x, points.v);
  for (size_t i = 0; i < v.size(); ++i)
    expected += cross(x_end[i] - centre * (1.0 / mass), x_end[i] - x_free[i]) * (points.masses[i] / h);
  CHECK(norm(angular_momentum(points, x_end, v) - expected) < 1e-8 * norm(expected));
}

TEST_CASE("what does not turn, or hardly as a whole, moves straight") {
  for (const Points& points : {cloud(20, {}, 0.0), cloud(20, {0.05, 0, 0}, 2.0)}) {
    const TurningFrame frame = turning_frame(points.masses, points.x, points.v, 0.01);
    CHECK(frame.spin == Vec3{});
  }
}

TEST_CASE("points on a line are not spun about it") {
  Points points;
  for (int i = 0; i < 9; ++i) {
    points.masses.push_back(0.01);
    points.x.push_back({0.1 * i, 1e-6 * (i % 2), 0.0});
    points.v.push_back({0.0, 0.7 * (0.1 * i - 0.4), (i % 2) * 0.1});
  }
  const double h = 0.01;
  const TurningFrame frame = turning_frame(points.masses, points.x, points.v, h);
  CHECK(std::fabs(frame.spin.x) < 0.1);
  CHECK(frame.spin.z == doctest::Approx(0.7).epsilon(0.05));
  const std::vector<Vec3> x_free = free_places(frame, points, h);
  std::vector<Vec3> v(points.x.size());
  end_velocities(frame, points.masses, points.x, x_free, x_free, h, v);
  for (size_t i = 0; i < v.size(); ++i) CHECK(norm(v[i] - points.v[i]) < 0.01);
}
