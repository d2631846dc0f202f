#include <stark/mechanics/whole_turn.h>

#include <algorithm>

#include <stark/base/rotation.h>
#include <stark/mechanics/dof_layout.h>

namespace stark {

namespace {

/// Below it a straight motion stretches by less than 1e-10: 10 Pa in steel [rad].
constexpr double kStraight = 1e-5;
constexpr double kLargestTurn = 1.0;  ///< what is beyond it stays straight [rad]
/// Of the inertia, which points on a line do not have about it.
constexpr double kSmallestInertia = 1e-9;

Vec3 increment(std::span<const double> direction, int32_t block) {
  if (block == kNoBlock) return {};
  const size_t k = 3 * static_cast<size_t>(block);
  return {direction[k], direction[k + 1], direction[k + 2]};
}

/// What a body turns about, and the mean motion of its points.
struct Centre {
  Vec3 place, motion;
};

Centre centre_of(std::span<const Vec3> x, std::span<const double> masses, std::span<const int32_t> blocks,
                 std::span<const double> direction) {
  Centre all, held;
  int32_t held_count = 0;
  double mass = 0.0;
  for (size_t i = 0; i < x.size(); ++i) {
    all.place += x[i] * masses[i];
    all.motion += increment(direction, blocks[i]) * masses[i];
    mass += masses[i];
    if (blocks[i] != kNoBlock) continue;
    held.place += x[i];
    ++held_count;
  }
  if (held_count > 0) return {held.place * (1.0 / held_count), {}};
  return {all.place * (1.0 / mass), all.motion * (1.0 / mass)};
}

/// The angular velocity w of least squares, sum m_i |u_i - v - w x r_i|^2.
Vec3 turn_in(std::span<const Vec3> x, std::span<const double> masses, std::span<const int32_t> blocks,
             std::span<const double> direction, const Centre& centre) {
  Mat3 second = Mat3::identity() * 0.0;
  Vec3 moment;
  for (size_t i = 0; i < x.size(); ++i) {
    const Vec3 r = x[i] - centre.place;
    second += outer(r, r) * masses[i];
    moment += cross(r, increment(direction, blocks[i]) - centre.motion) * masses[i];
  }
  const double size = trace(second);
  if (!(size > 0.0)) return {};
  return inverse(Mat3::identity() * (size * (1.0 + kSmallestInertia)) - second) * moment;
}

}  // namespace

bool complete_turn(const TurningRange& range, std::span<const Vec3> from, std::span<const int32_t> blocks,
                   std::span<const double> direction, double alpha, std::span<Vec3> to) {
  const Centre centre = centre_of(from, range.masses, blocks, direction);
  Vec3 turn = turn_in(from, range.masses, blocks, direction, centre) * alpha;
  const double angle = norm(turn);
  if (!(angle > kStraight)) return false;
  Vec3 pivot = centre.place;
  if (range.is_held) pivot += cross(turn, centre.motion) * (alpha / (angle * angle));
  turn *= std::min(1.0, kLargestTurn / angle);
  const Mat3 beyond = exp_rotation(turn) - Mat3::identity() - skew(turn);
  for (size_t i = 0; i < from.size(); ++i)
    if (blocks[i] != kNoBlock) to[i] += beyond * (from[i] - pivot);
  return true;
}

}  // namespace stark
