// Rotations in R^3: exponential map, quaternions, interpolation. Matrices map body to world coordinates.
#pragma once

#include <stark/base/math.h>

namespace stark {

/// Unit quaternion, scalar part first.
struct Quaternion {
  double w = 1.0, x = 0.0, y = 0.0, z = 0.0;
  constexpr bool operator==(const Quaternion&) const = default;
};

/// exp([w]x): rotation by |w| radians about w (Rodrigues; series near zero).
Mat3 exp_rotation(const Vec3& w);
/// Rotation vector w with |w| <= pi and exp_rotation(w) = R.
Vec3 log_rotation(const Mat3& R);
Mat3 to_matrix(const Quaternion& q);      ///< q is normalised first
Quaternion to_quaternion(const Mat3& R);  ///< the representative with w >= 0
/// Nearest well-conditioned rotation to an almost orthogonal matrix (Gram-Schmidt on the columns).
Mat3 orthonormalized(const Mat3& R);
/// Point at `fraction` of the constant-velocity rotation from A to B.
Mat3 interpolate_rotation(const Mat3& A, const Mat3& B, double fraction);

}  // namespace stark
