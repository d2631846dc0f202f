// Rotations: exponential and logarithm against each other and against a long double power series, quaternions
// against matrices, at ordinary angles and where formulas cancel (tiny angles, half turns).
#include <stark/base/rotation.h>

#include <array>
#include <numbers>
#include <random>
#include <vector>

#include <doctest/doctest.h>

namespace {

using namespace stark;

double difference(const Mat3& a, const Mat3& b) {
  double largest = 0.0;
  for (int k = 0; k < 9; ++k) largest = std::fmax(largest, std::fabs(a.m[k] - b.m[k]));
  return largest;
}

double difference(const Vec3& a, const Vec3& b) { return max_abs(a - b); }

/// Sum of [w]^k / k! in long double; converges for every w, here |w| <= pi.
Mat3 power_series(const Vec3& w) {
  using Matrix = std::array<long double, 9>;
  const Mat3 skewed = skew(w);
  Matrix sum{1, 0, 0, 0, 1, 0, 0, 0, 1}, term = sum;
  for (int k = 1; k < 60; ++k) {
    Matrix next{};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int l = 0; l < 3; ++l) next[3 * i + j] += term[3 * i + l] * skewed(l, j) / k;
    term = next;
    for (int e = 0; e < 9; ++e) sum[e] += term[e];
  }
  Mat3 result;
  for (int e = 0; e < 9; ++e) result.m[e] = static_cast<double>(sum[e]);
  return result;
}

/// Random axes times angles from 1e-14 to pi, the threshold of the series and half turns included.
std::vector<Vec3> rotation_vectors() {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  std::vector<Vec3> vectors{{0, 0, 0}};
  for (double angle :
       {1e-14, 1e-9, 1e-6, 0.9e-4, 1.1e-4, 1e-3, 0.1, 1.0, 2.0, 3.0, std::numbers::pi - 1e-6}) {
    for (int sample = 0; sample < 20; ++sample)
      vectors.push_back(angle * normalized(Vec3{normal(random), normal(random), normal(random)}));
    vectors.push_back({angle, 0, 0});
    vectors.push_back({0, 0, -angle});
  }
  return vectors;
}

}  // namespace

TEST_CASE("the exponential map agrees with its power series and is a rotation") {
  for (const Vec3& w : rotation_vectors()) {
    const Mat3 R = exp_rotation(w);
    CHECK(difference(R, power_series(w)) < 1e-15 * 4);  // a few roundings of numbers below one
    CHECK(difference(R * transpose(R), Mat3::identity()) < 1e-15 * 4);
    CHECK(std::fabs(determinant(R) - 1.0) < 1e-15 * 4);
  }
  CHECK(exp_rotation({}) == Mat3::identity());
}

TEST_CASE("the logarithm inverts the exponential") {
  for (const Vec3& w : rotation_vectors()) {
    // Near a half turn the matrix determines the vector to about the square root of rounding at worst; the
    // quaternion route keeps it at rounding.
    CHECK(difference(log_rotation(exp_rotation(w)), w) < 1e-14);
  }
  const Vec3 half_turn = log_rotation(Mat3::diagonal({-1, 1, -1}));
  CHECK(std::fabs(norm(half_turn) - std::numbers::pi) < 1e-15 * 4);
  CHECK(std::fabs(half_turn.y) == doctest::Approx(std::numbers::pi));
}

TEST_CASE("quaternions and matrices describe the same rotation") {
  for (const Vec3& w : rotation_vectors()) {
    const Mat3 R = exp_rotation(w);
    const Quaternion q = to_quaternion(R);
    CHECK(q.w >= 0.0);
    CHECK(std::fabs(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z - 1.0) < 1e-15 * 4);
    CHECK(difference(to_matrix(q), R) < 1e-15 * 8);
    CHECK(difference(to_matrix({3 * q.w, 3 * q.x, 3 * q.y, 3 * q.z}), R) < 1e-15 * 8);  // any length
  }
  // A quarter turn about z, scalar part first.
  const double s = std::sqrt(0.5);
  CHECK(difference(to_matrix({s, 0, 0, s}) * Vec3{1, 0, 0}, Vec3{0, 1, 0}) < 1e-15);
}

TEST_CASE("orthonormalisation repairs a drifted rotation and leaves an exact one alone") {
  const Mat3 R = exp_rotation({0.3, -1.0, 0.7});
  CHECK(difference(orthonormalized(R), R) < 1e-15 * 4);
  Mat3 drifted = R;
  for (int k = 0; k < 9; ++k) drifted.m[k] *= 1.0 + 1e-6 * (k - 4);
  const Mat3 repaired = orthonormalized(drifted);
  CHECK(difference(repaired * transpose(repaired), Mat3::identity()) < 1e-15 * 4);
  CHECK(difference(repaired, R) < 2e-5);  // no further away than the drift itself
}

TEST_CASE("interpolation is the constant-velocity rotation between its ends") {
  const Mat3 A = exp_rotation({0.4, 0.1, -0.2});
  const Vec3 turn{0.0, 1.2, 0.5};
  const Mat3 B = exp_rotation(turn) * A;
  CHECK(difference(interpolate_rotation(A, B, 0.0), A) < 1e-15 * 4);
  CHECK(difference(interpolate_rotation(A, B, 1.0), B) < 1e-15 * 8);
  CHECK(difference(interpolate_rotation(A, B, 0.25), exp_rotation(turn * 0.25) * A) < 1e-15 * 8);
}
