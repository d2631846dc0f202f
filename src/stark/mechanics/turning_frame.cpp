#include <stark/mechanics/turning_frame.h>

#include <algorithm>

#include <stark/base/rotation.h>

namespace stark {

namespace {

/// Part of the inertia of all axes that each is given beside its own: a rod, which has hardly any about
/// itself, would whirl. What that takes from the spin about others is left over from each of some rounds to
/// the next.
constexpr double kAddedInertia = 0.01;
constexpr int kRounds = 6;
/// Angles that a body turns by in a step: up to the first the frame turns along, from the second on not at
/// all [rad]. Forces that act at the end of so long a step could feed the body.
constexpr double kFullTurn = 0.8, kLargestTurn = 1.2;
/// Shares of the kinetic energy relative to the centre that are those of the turn: below the first the frame
/// does not turn, above the second it turns as the body does.
constexpr double kLoose = 0.5, kRigid = 0.9;

Vec3 mean(std::span<const double> masses, std::span<const Vec3> values) {
  Vec3 sum;
  double mass = 0.0;
  for (size_t i = 0; i < values.size(); ++i) {
    sum += values[i] * masses[i];
    mass += masses[i];
  }
  return sum * (1.0 / mass);
}

/// Angular velocity of points with an angular momentum about their centre [rad/s].
Vec3 spin_of(std::span<const double> masses, std::span<const Vec3> x, const Vec3& centre,
             const Vec3& angular_momentum) {
  Mat3 second;
  for (size_t i = 0; i < x.size(); ++i) second += outer(x[i] - centre, x[i] - centre) * masses[i];
  const double size = trace(second);
  if (!(size > 0.0)) return {};
  const Mat3 inertia = Mat3::identity() * size - second;
  const Mat3 inverted = inverse(inertia + Mat3::identity() * (kAddedInertia * size));
  Vec3 spin;
  for (int k = 0; k < kRounds; ++k) spin += inverted * (angular_momentum - inertia * spin);
  return spin;
}

}  // namespace

TurningFrame turning_frame(std::span<const double> masses, std::span<const Vec3> x, std::span<const Vec3> v,
                           double h) {
  TurningFrame frame{mean(masses, x), mean(masses, v), {}, Mat3::identity(), {}};
  double energy = 0.0;  // twice the kinetic energy
  for (size_t i = 0; i < x.size(); ++i) {
    const Vec3 u = v[i] - frame.velocity;
    frame.angular_momentum += cross(x[i] - frame.centre, u) * masses[i];
    energy += masses[i] * squared_norm(u);
  }
  const Vec3 spin = spin_of(masses, x, frame.centre, frame.angular_momentum);
  const double share = energy > 0.0 ? dot(spin, frame.angular_momentum) / energy : 0.0;
  const double part = std::clamp((share - kLoose) / (kRigid - kLoose), 0.0, 1.0);
  const double known = std::clamp((kLargestTurn - h * norm(spin)) / (kLargestTurn - kFullTurn), 0.0, 1.0);
  frame.spin = spin * (part * known);
  frame.turn = exp_rotation(frame.spin * h);
  return frame;
}

Vec3 free_place(const TurningFrame& frame, const Vec3& x, const Vec3& v, double h) {
  const Vec3 r = frame.turn * (x - frame.centre);
  const Vec3 u = v - frame.velocity - cross(frame.spin, x - frame.centre);
  const Vec3 centrifugal = cross(cross(frame.spin, r), frame.spin);
  return frame.centre + frame.velocity * h + r + transpose(frame.turn) * u * h + centrifugal * (h * h);
}

void end_velocities(const TurningFrame& frame, std::span<const double> masses, std::span<const Vec3> x,
                    std::span<const Vec3> x_free, std::span<const Vec3> x_end, double h, std::span<Vec3> v) {
  const Vec3 centre = mean(masses, x_end), moved = frame.centre + frame.velocity * h;
  Vec3 lacking = frame.angular_momentum;
  for (size_t i = 0; i < x.size(); ++i) {
    const Vec3 r = x_end[i] - centre;
    const Vec3 u = (x_end[i] - moved - frame.turn * (x[i] - frame.centre)) / h;
    v[i] = frame.velocity + cross(frame.spin, r) + u;
    lacking += cross(r, (x_end[i] - x_free[i]) / h - v[i]) * masses[i];
  }
  const Vec3 spin = spin_of(masses, x_end, centre, lacking);
  for (size_t i = 0; i < x.size(); ++i) v[i] += cross(spin, x_end[i] - centre);
}

}  // namespace stark
