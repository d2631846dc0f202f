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

/// Where free motion brings R in h seconds, backwards where h < 0. The kinetic energy is split into that of a
/// symmetric top, whose motion is exact, and what the two principal moments that are nearest to each other
/// differ by; steps of a quarter of a radian, symmetric and of fourth order by composition. What resists a
/// turn least has the two other moments nearly equal (J_y <= J_x + J_z), so needles are as exact as cubes;
/// implicit rules on the group find no solution there. Exact at once where the rotation is steady.
/// [Touma, Wisdom 1994; Suzuki 1990; Hairer, Lubich, Wanner 2006, sec. II.5, VII.5]
Mat3 free_rotation(const Mat3& R, const Vec3& moments, const Vec3& momentum, double h);

}  // namespace stark
