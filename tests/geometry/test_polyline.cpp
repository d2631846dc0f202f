// Polylines: tangents, frames that turn no more than their tangents, straightening.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include <stark/geometry/polyline.h>

using namespace stark;

namespace {

std::vector<Vec3> circle(int count, double angle) {
  std::vector<Vec3> points;
  for (int i = 0; i <= count; ++i) {
    const double a = angle * i / count;
    points.push_back({2.0 * std::cos(a), 2.0 * std::sin(a), 0.0});
  }
  return points;
}

std::vector<Vec3> helix(int count) {
  std::vector<Vec3> points;
  for (int i = 0; i <= count; ++i) {
    const double a = 2.0 * std::numbers::pi * i / count;
    points.push_back({std::cos(a), std::sin(a), 0.5 * a});
  }
  return points;
}

}  // namespace

TEST_CASE("tangents of a circle are those of its edges at the ends and perpendicular to the radius inside") {
  const std::vector<Vec3> points = circle(8, 1.2), tangents = polyline_tangents(points);
  REQUIRE(tangents.size() == points.size());
  CHECK(max_abs(tangents.front() - normalized(points[1] - points[0])) < 1e-15);
  CHECK(max_abs(tangents.back() - normalized(points[8] - points[7])) < 1e-15);
  for (int i = 1; i < 8; ++i) CHECK(std::fabs(dot(tangents[i], points[i])) < 1e-14);
}

TEST_CASE("frames are rotations with the tangent as third axis") {
  for (const auto& points : {circle(8, 1.2), helix(20)}) {
    const std::vector<Vec3> tangents = polyline_tangents(points);
    const std::vector<Mat3> frames = polyline_frames(points, Vec3{0.3, 0.1, 1.0});
    for (size_t i = 0; i < points.size(); ++i) {
      for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k)
          CHECK(std::fabs(dot(frames[i].column(j), frames[i].column(k)) - (j == k)) < 1e-14);
      CHECK(determinant(frames[i]) == doctest::Approx(1.0));
      CHECK(max_abs(frames[i].column(2) - tangents[i]) < 1e-15);
    }
  }
}

TEST_CASE("along a plane curve the axis across the plane stays, whatever the bend") {
  const std::vector<Mat3> frames = polyline_frames(circle(8, 5.0), Vec3{0, 0, 3});
  for (const Mat3& frame : frames) CHECK(max_abs(frame.column(0) - Vec3{0, 0, 1}) < 1e-14);
}

TEST_CASE("a turn of a helix turns its frames by its writhe: 2 pi (1 - sin of the slope)") {
  const double slope = std::atan2(0.5, 1.0), expected = 2.0 * std::numbers::pi * (1.0 - std::sin(slope));
  // Interior frames over one turn: transport keeps the angle to the Frenet normal up to its torsion, which
  // sums to 2 pi sin(slope). The points next to the ends have tangents of the same slope.
  std::vector<Vec3> points;
  const int count = 400;
  for (int i = -1; i <= count + 1; ++i) {
    const double a = 2.0 * std::numbers::pi * i / count;
    points.push_back({std::cos(a), std::sin(a), 0.5 * a});
  }
  const std::vector<Mat3> frames = polyline_frames(points);
  const Mat3 turn = transpose(frames[1]) * frames[count + 1];
  const double angle = std::atan2(turn(1, 0), turn(0, 0));
  CHECK(std::cos(angle - expected) == doctest::Approx(1.0).epsilon(1e-3));
  CHECK(turn(2, 2) == doctest::Approx(1.0).epsilon(1e-12));
}

TEST_CASE("without a normal the axis farthest from the tangent is taken") {
  const std::vector<Mat3> frames = polyline_frames(std::vector<Vec3>{{0, 0, 0}, {0.2, 0.1, 5}});
  CHECK(frames[0].column(0).y > 0.99);
}

TEST_CASE("straightened points keep the lengths of their edges") {
  const std::vector<Vec3> bent = circle(5, 2.0), straight = straightened(bent, {0, 0, 1});
  const std::vector<double> before = polyline_lengths(bent), after = polyline_lengths(straight);
  REQUIRE(before.size() == 5);
  for (int i = 0; i < 5; ++i) CHECK(after[i] == doctest::Approx(before[i]).epsilon(1e-14));
  CHECK(max_abs(cross(straight[5] - straight[0], {0, 0, 1})) == 0.0);
  CHECK(straight[0] == bent[0]);
}
