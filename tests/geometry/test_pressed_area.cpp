// Where two flat faces lie on each other.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include <stark/base/rotation.h>
#include <stark/geometry/pressed_area.h>

using namespace stark;

namespace {

const Vec3 kUp{0, 0, 1};

/// Rectangle about a centre at a height; corners in no order.
std::vector<Vec3> rectangle(double a, double b, const Vec3& centre = {}) {
  std::vector<Vec3> corners;
  for (const double x : {-0.5, 0.5})
    for (const double y : {-0.5, 0.5}) corners.push_back(centre + Vec3{a * x, b * y, 0});
  return corners;
}

/// Mean distance of the points of a square of side 1 from its centre.
const double kSquare = (std::sqrt(2.0) + std::asinh(1.0)) / 6.0;

}  // namespace

TEST_CASE("equal squares share all, and points are at 0.541 of the distance of the corners") {
  const auto area = find_pressed_area(rectangle(1, 1), rectangle(1, 1, {0, 0, 0.1}), kUp);
  REQUIRE(area);
  CHECK(norm(area->centre) < 1e-15);
  CHECK(area->part == doctest::Approx(kSquare / std::sqrt(0.5)).epsilon(1e-12));
  CHECK(area->of_smaller == doctest::Approx(1.0));
  CHECK_FALSE(area->is_inside);
}

TEST_CASE("what hangs over an edge is left out") {
  const auto area = find_pressed_area(rectangle(1, 1, {0.25, 0, 0}), rectangle(1, 2), kUp);
  REQUIRE(area);
  CHECK(norm(area->centre - Vec3{0.125, 0, 0}) < 1e-15);
  CHECK(area->of_smaller == doctest::Approx(0.75));
  double mean = 0.0;  // of a rectangle of 0.75 by 1, by points in the middle of cells
  for (int i = 0; i < 400; ++i)
    for (int k = 0; k < 400; ++k) mean += std::hypot(0.75 * ((i + 0.5) / 400 - 0.5), (k + 0.5) / 400 - 0.5);
  CHECK(area->part == doctest::Approx(mean / 160000 / 0.625).epsilon(1e-5));
}

TEST_CASE("squares that are turned by 45 degrees share an octagon") {
  std::vector<Vec3> turned = rectangle(1, 1);
  for (Vec3& x : turned) x = exp_rotation({0, 0, std::numbers::pi / 4}) * x;
  const auto area = find_pressed_area(rectangle(1, 1), turned, kUp);
  REQUIRE(area);
  const double octagon = 2.0 * (std::sqrt(2.0) - 1.0);
  CHECK(area->of_smaller == doctest::Approx(octagon).epsilon(1e-12));
  // Of a regular one with the inner radius r: (r/3) (sqrt(1 + t^2) + asinh(t)/t), t = tan(22.5 degrees).
  const double t = std::tan(std::numbers::pi / 8), root = std::sqrt(1.0 + t * t);
  CHECK(area->part == doctest::Approx((root + std::asinh(t) / t) / 3.0 / root).epsilon(1e-12));
}

TEST_CASE("edges that cross under a small angle carry little") {
  std::vector<Vec3> turned = rectangle(1, 1);
  for (Vec3& x : turned) x = exp_rotation({0, 0, 1e-4}) * x;
  const auto area = find_pressed_area(rectangle(1, 3), turned, kUp);  // crossings in the middle of two edges
  REQUIRE(area);
  CHECK(area->part == doctest::Approx(kSquare / std::sqrt(0.5)).epsilon(1e-3));
}

TEST_CASE("a face inside of the other is told apart") {
  CHECK(find_pressed_area(rectangle(1, 1), rectangle(2, 2), kUp)->is_inside);
  CHECK_FALSE(find_pressed_area(rectangle(2, 2), rectangle(1, 1), kUp)->is_inside);
}

TEST_CASE("none where faces are beside each other or not convex") {
  CHECK_FALSE(find_pressed_area(rectangle(1, 1), rectangle(1, 1, {1.5, 0, 0}), kUp));
  CHECK_FALSE(find_pressed_area(rectangle(1, 1), rectangle(1, 1, {1.0, 0, 0}), kUp));  // along an edge
  std::vector<Vec3> arrow = rectangle(1, 1);
  arrow.push_back({0.1, 0.1, 0});
  CHECK_FALSE(find_pressed_area(rectangle(1, 1), arrow, kUp));
}
