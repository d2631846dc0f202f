// Free motion of a rigid body: momentum, reversibility, order of the rule, steady rotation, axes without
// inertia.
#include <doctest/doctest.h>

#include <cmath>

#include <stark/base/rotation.h>
#include <stark/mechanics/free_rotation.h>

using namespace stark;

namespace {

const Vec3 kMoments{0.01, 0.02, 0.03};
const Mat3 kStart = exp_rotation({0.3, -0.8, 0.5});

double difference(const Mat3& A, const Mat3& B) { return norm(log_rotation(A * transpose(B))); }

/// By Euler's equations in the body frame, classical Runge-Kutta with steps so short that their error is
/// rounding.
Mat3 integrate(Mat3 R, const Vec3& L, double h) {
  constexpr int kSteps = 20000;
  const double k = h / kSteps;
  const auto rate = [&](const Mat3& Q) { return skew(velocity_of_momentum(Q, kMoments, L)) * Q; };
  for (int n = 0; n < kSteps; ++n) {
    const Mat3 a = rate(R), b = rate(R + a * (0.5 * k)), c = rate(R + b * (0.5 * k)), d = rate(R + c * k);
    R = R + (a + b * 2.0 + c * 2.0 + d) * (k / 6.0);
  }
  return orthonormalized(R);
}

}  // namespace

TEST_CASE("momentum and velocity are inverse to each other; axes without inertia do not turn") {
  const Vec3 w{1.0, -2.0, 3.0};
  const Vec3 L = angular_momentum(kStart, kMoments, w);
  CHECK(norm(velocity_of_momentum(kStart, kMoments, L) - w) < 1e-14);
  CHECK(velocity_of_momentum(Mat3::identity(), {0.01, 0.02, 0.0}, {0.1, 0.1, 0.1}) == Vec3{10.0, 5.0, 0.0});
}

TEST_CASE("a tumbling body follows Euler's equations and comes back where time runs backwards") {
  for (const double speed : {0.1, 5.0, 40.0}) {
    const Vec3 L = angular_momentum(kStart, kMoments, Vec3{0.1, 1.0, -0.2} * speed);
    const double h = 1.0 / 60.0;
    const Mat3 end = free_rotation(kStart, kMoments, L, h);
    CHECK(difference(end, integrate(kStart, L, h)) < 1e-6 * speed * h + 1e-12);
    CHECK(difference(free_rotation(end, kMoments, L, -h), kStart) < 1e-12);
  }
}

TEST_CASE("steady rotation is exact whatever its speed") {
  for (const Vec3& axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}})
    for (const double angle : {1e-6, 0.3, 2.0, 40.0}) {
      const Vec3 w = kStart * axis * angle;
      const Mat3 end = free_rotation(kStart, kMoments, angular_momentum(kStart, kMoments, w), 1.0);
      CHECK(difference(end, exp_rotation(w) * kStart) < 1e-13 * std::fmax(1.0, angle));
    }
  CHECK(difference(free_rotation(kStart, kMoments, {}, 1.0), kStart) == 0.0);
}

TEST_CASE("a needle, whose momentum says little about its turn, keeps its energy") {
  // 5 mm long, 30 um thick, the moments of a random scene; L is 1e7 rad/s about the long axis.
  const Vec3 moments{3.33405748e-19, 3.19411726e-15, 3.19442267e-15};
  const auto energy = [&](const Mat3& R, const Vec3& L) {
    return dot(L, velocity_of_momentum(R, moments, L));
  };
  const Vec3 L = angular_momentum(kStart, moments, kStart * Vec3{-61.7, -1579.2, 43.8});
  Mat3 R = kStart;
  for (int n = 0; n < 100; ++n) R = free_rotation(R, moments, L, 1e-3);
  CHECK(energy(R, L) == doctest::Approx(energy(kStart, L)).epsilon(1e-6));
  const Mat3 end = free_rotation(kStart, moments, L, 1e-3);
  CHECK(difference(free_rotation(end, moments, L, -1e-3), kStart) < 1e-6);
}

TEST_CASE("a motion that no step resolves ends as a rotation") {
  const Vec3 L = angular_momentum(kStart, kMoments, {1e9, 2e9, -3e9});
  const Mat3 end = free_rotation(kStart, kMoments, L, 1.0);
  CHECK(std::fabs(determinant(end) - 1.0) < 1e-12);
}
