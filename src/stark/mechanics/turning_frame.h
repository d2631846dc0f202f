// A frame that turns with a deformable body, in which implicit Euler sees little motion: what it damps is
// then what the body does beside its turn. [theory eq. 26f]
#pragma once

#include <span>

#include <stark/base/math.h>

namespace stark {

struct TurningFrame {
  Vec3 centre, velocity;  ///< of the centre of mass at the start of the step [m, m/s]
  Vec3 spin;              ///< its angular velocity in the step [rad/s]
  Mat3 turn;              ///< in the step
  Vec3 angular_momentum;  ///< of the points about their centre at the start [kg m^2/s]
};

/// The frame of points at x [m] with velocities v [m/s] and masses [kg] for a step of length h [s]: it turns
/// as the points do in the mean, the less so the less of their motion that is.
TurningFrame turning_frame(std::span<const double> masses, std::span<const Vec3> x, std::span<const Vec3> v,
                           double h);

/// Where inertia brings a point in the step [m].
Vec3 free_place(const TurningFrame& frame, const Vec3& x, const Vec3& v, double h);

/// Velocities v at the end of a step from x to x_end [m], of points that inertia would have brought to
/// x_free: with the angular momentum of the start and the impulse of the torques.
void end_velocities(const TurningFrame& frame, std::span<const double> masses, std::span<const Vec3> x,
                    std::span<const Vec3> x_free, std::span<const Vec3> x_end, double h, std::span<Vec3> v);

}  // namespace stark
