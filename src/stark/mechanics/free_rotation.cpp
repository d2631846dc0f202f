#include <stark/mechanics/free_rotation.h>

#include <algorithm>
#include <cmath>

#include <stark/base/rotation.h>

namespace stark {

namespace {

constexpr double kSubstep = 0.05;      ///< [rad] a step of the midpoint rule turns by no more
constexpr int kMostSubsteps = 1024;    ///< of motions that no step resolves
constexpr int kMostIterations = 30;    ///< of the fixed point; each gains more than a digit
constexpr double kFixedPoint = 1e-15;  ///< relative change at which it is found
constexpr double kSteady = 1e-14;      ///< change of w along the way, relative, below which it is steady

/// Angular velocity in the middle of a step of length k from R.
Vec3 middle_velocity(const Mat3& R, const Vec3& moments, const Vec3& momentum, double k, const Vec3& guess) {
  Vec3 w = guess;
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    const Vec3 next = velocity_of_momentum(exp_rotation(w * (0.5 * k)) * R, moments, momentum);
    const double change = norm(next - w);
    w = next;
    if (!(change > kFixedPoint * norm(w))) break;
  }
  return w;
}

}  // namespace

Vec3 angular_momentum(const Mat3& R, const Vec3& moments, const Vec3& angular_velocity) {
  const Vec3 w = transpose(R) * angular_velocity;
  return R * Vec3{moments.x * w.x, moments.y * w.y, moments.z * w.z};
}

Vec3 velocity_of_momentum(const Mat3& R, const Vec3& moments, const Vec3& momentum) {
  const auto divided = [](double a, double b) { return b > 0.0 ? a / b : 0.0; };
  const Vec3 L = transpose(R) * momentum;
  return R * Vec3{divided(L.x, moments.x), divided(L.y, moments.y), divided(L.z, moments.z)};
}

Mat3 free_rotation(const Mat3& R, const Vec3& moments, const Vec3& momentum, double h) {
  Vec3 w = velocity_of_momentum(R, moments, momentum);
  // L along a principal axis, or a sphere: w stays what it is.
  if (norm(cross(w, momentum)) <= kSteady * norm(w) * norm(momentum)) return exp_rotation(w * h) * R;
  // No motion with this momentum is faster than L about the axis of the smallest moment.
  const double smallest = std::min({moments.x, moments.y, moments.z});
  const double fastest = std::min(norm(momentum) / smallest, 1e3 * norm(w));
  const int count = static_cast<int>(
      std::clamp(std::ceil(fastest * std::fabs(h) / kSubstep), 1.0, static_cast<double>(kMostSubsteps)));
  const double k = h / count;
  Mat3 turned = R;
  for (int step = 0; step < count; ++step) {
    w = middle_velocity(turned, moments, momentum, k, w);
    turned = exp_rotation(w * k) * turned;
  }
  return orthonormalized(turned);
}

}  // namespace stark
