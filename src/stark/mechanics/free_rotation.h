// Rotation of a rigid body on which nothing acts: the spatial angular momentum L is constant, the rotation
// stays on the group (step phase 1). [theory eq. 9a]
#pragma once

#include <stark/base/math.h>

namespace stark {

/// R J R^T w [kg m^2/s] for the angular velocity w [rad/s, world axes]; moments: the diagonal of J in the
/// principal frame [kg m^2], R from there to the world.
Vec3 angular_momentum(const Mat3& R, const Vec3& moments, const Vec3& angular_velocity);
/// Its inverse; zero about axes without inertia.
Vec3 velocity_of_momentum(const Mat3& R, const Vec3& moments, const Vec3& momentum);

/// Where free motion brings R in h seconds, backwards where h < 0. Steps of the implicit midpoint rule on the
/// group, exp(k w) R with w = R_m J^-1 R_m^T L and R_m = exp(k w/2) R: symmetric, of second order, and short
/// enough to turn by a twentieth of a radian; exact at once where the rotation is steady.
/// [Hairer, Lubich, Wanner 2006, sec. VII.5]
Mat3 free_rotation(const Mat3& R, const Vec3& moments, const Vec3& momentum, double h);

}  // namespace stark
