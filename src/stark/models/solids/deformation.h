// Kinematics of linear tetrahedra shared by the solid laws.
#pragma once

#include <stark/mechanics/define.h>

namespace stark::models {

inline Mat3 edge_matrix(const Vec3& p0, const Vec3& p1, const Vec3& p2, const Vec3& p3) {
  return Mat3::from_columns(p1 - p0, p2 - p0, p3 - p0);
}

inline Mat3 rest_edges(PotentialBuilder& b) { return edge_matrix(b.X(0), b.X(1), b.X(2), b.X(3)); }

inline Mat3 deformation_gradient(PotentialBuilder& b) {
  return edge_matrix(b.x(0), b.x(1), b.x(2), b.x(3)) * inverse(rest_edges(b));
}

inline Mat3 previous_deformation_gradient(PotentialBuilder& b) {
  return edge_matrix(b.x_prev(0), b.x_prev(1), b.x_prev(2), b.x_prev(3)) * inverse(rest_edges(b));
}

inline Scalar rest_volume(PotentialBuilder& b) { return determinant(rest_edges(b)) / 6.0; }

}  // namespace stark::models
