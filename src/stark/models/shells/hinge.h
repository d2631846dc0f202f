// Kinematics of a hinge: vertices 0, 1 of the shared edge and 2, 3 opposite to it, triangles (0, 1, 2) and
// (1, 0, 3).
#pragma once

#include <stark/mechanics/define.h>

namespace stark::models {

struct HingeGeometry {
  Vec3 edge, normal_a, normal_b;  ///< edge 0 -> 1; normals with twice the areas as lengths
};

inline HingeGeometry hinge(const Vec3& p0, const Vec3& p1, const Vec3& p2, const Vec3& p3) {
  const Vec3 e = p1 - p0;
  return {e, cross(e, p2 - p0), cross(p3 - p0, e)};
}

/// Signed angle between the normals [rad], zero for a flat hinge.
inline Scalar fold_angle(const HingeGeometry& h) {
  const Scalar sine = dot(cross(h.normal_a, h.normal_b), h.edge) / norm(h.edge);
  return atan2(sine, dot(h.normal_a, h.normal_b));
}

inline HingeGeometry hinge_at(PotentialBuilder& b, PotentialBuilder::Position at) {
  return hinge((b.*at)(0), (b.*at)(1), (b.*at)(2), (b.*at)(3));
}

inline HingeGeometry rest_hinge(PotentialBuilder& b) { return hinge_at(b, &PotentialBuilder::X); }

/// 3 / (A_a + A_b) of the rest shape [1/m^2].
inline Scalar hinge_weight(PotentialBuilder& b) {
  const HingeGeometry rest = rest_hinge(b);
  return 6.0 / (norm(rest.normal_a) + norm(rest.normal_b));
}

/// d/(2 h) (theta - theta_n)^2 [J].
inline Scalar viscous_energy(PotentialBuilder& b) {
  const Scalar d = b.parameter("bending_damping", "J s", "viscosity of the fold angle rate");
  const Scalar theta = fold_angle(hinge_at(b, &PotentialBuilder::x));
  const Scalar theta_prev = fold_angle(hinge_at(b, &PotentialBuilder::x_prev));
  return 0.5 * d / b.time_step() * square(theta - theta_prev);
}

/// Rest shape around [0, 1]: two triangles folded by a moderate random angle.
PotentialSample sample_hinge(std::mt19937_64& random);

}  // namespace stark::models
