#include <stark/mechanics/free_rotation.h>

#include <algorithm>
#include <array>
#include <cmath>

#include <stark/base/rotation.h>

namespace stark {

namespace {

constexpr double kSubstep = 0.25;    ///< [rad] a step of the composition turns by no more
constexpr int kMostSubsteps = 4096;  ///< of motions that no step resolves
constexpr double kSteady = 1e-14;    ///< change of w along the way, relative, below which it is steady

/// Suzuki's composition of five steps of a symmetric method of second order to one of fourth.
constexpr double kCubeRootOfFour = 1.5874010519681996;  // std::cbrt differs from one processor to another
constexpr double kOuter = 1.0 / (4.0 - kCubeRootOfFour);
constexpr std::array<double, 5> kStages{kOuter, kOuter, 1.0 - 4.0 * kOuter, kOuter, kOuter};

double inverse_or_zero(double moment) { return moment > 0.0 ? 1.0 / moment : 0.0; }

/// The kinetic energy, split for steps: L_o^2 (1/J_o - t)/2 + |L|^2 t/2 of a symmetric top about the
/// principal axis o, and (L_a^2 - L_b^2) d/2 of what a and b differ by.
class SplitTop {
 public:
  SplitTop(const Vec3& moments, const Vec3& momentum) : momentum_(momentum) {
    const Vec3 inverse{inverse_or_zero(moments.x), inverse_or_zero(moments.y), inverse_or_zero(moments.z)};
    const auto difference = [&](int o) { return std::fabs(inverse[(o + 1) % 3] - inverse[(o + 2) % 3]); };
    for (int o = 1; o < 3; ++o)
      if (difference(o) < difference(axis_)) axis_ = o;
    const double a = inverse[(axis_ + 1) % 3], b = inverse[(axis_ + 2) % 3];
    transverse_ = (a + b) / 2.0;
    half_difference_ = (a - b) / 2.0;
    relative_ = inverse[axis_] - transverse_;
  }

  /// Angular velocity of the top with its turn about its axis [rad/s].
  double speed(const Mat3& R) const {
    return norm(momentum_) * transverse_ + std::fabs(component(R, axis_) * relative_);
  }

  /// A symmetric step of second order.
  void step(Mat3& R, double k) const {
    turn_as_top(R, k / 2.0);
    turn_about(R, (axis_ + 1) % 3, half_difference_ * k / 2.0);
    turn_about(R, (axis_ + 2) % 3, -half_difference_ * k);
    turn_about(R, (axis_ + 1) % 3, half_difference_ * k / 2.0);
    turn_as_top(R, k / 2.0);
  }

 private:
  double component(const Mat3& R, int axis) const { return dot(R.column(axis), momentum_); }

  /// The flow of L_axis^2 c/2 for the time in `scale` = c k: a turn about the axis.
  void turn_about(Mat3& R, int axis, double scale) const {
    R = exp_rotation(R.column(axis) * (component(R, axis) * scale)) * R;
  }

  void turn_as_top(Mat3& R, double k) const {
    turn_about(R, axis_, relative_ * k);
    R = exp_rotation(momentum_ * (transverse_ * k)) * R;
  }

  Vec3 momentum_;
  int axis_ = 0;
  double transverse_ = 0.0, half_difference_ = 0.0, relative_ = 0.0;
};

}  // namespace

Vec3 angular_momentum(const Mat3& R, const Vec3& moments, const Vec3& angular_velocity) {
  const Vec3 w = transpose(R) * angular_velocity;
  return R * Vec3{moments.x * w.x, moments.y * w.y, moments.z * w.z};
}

Vec3 velocity_of_momentum(const Mat3& R, const Vec3& moments, const Vec3& momentum) {
  const Vec3 L = transpose(R) * momentum;
  return R * Vec3{L.x * inverse_or_zero(moments.x), L.y * inverse_or_zero(moments.y),
                  L.z * inverse_or_zero(moments.z)};
}

Mat3 free_rotation(const Mat3& R, const Vec3& moments, const Vec3& momentum, double h) {
  const Vec3 w = velocity_of_momentum(R, moments, momentum);
  // L along a principal axis, or a sphere: w stays what it is.
  if (norm(cross(w, momentum)) <= kSteady * norm(w) * norm(momentum)) return exp_rotation(w * h) * R;
  const SplitTop top(moments, momentum);
  const int count = static_cast<int>(
      std::clamp(std::ceil(top.speed(R) * std::fabs(h) / kSubstep), 1.0, static_cast<double>(kMostSubsteps)));
  Mat3 turned = R;
  for (int step = 0; step < count; ++step)
    for (const double part : kStages) top.step(turned, part * h / count);
  return orthonormalized(turned);
}

}  // namespace stark
