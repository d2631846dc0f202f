// Distances of contact stencils as formulas of their vertices; the type of the closest features was found
// before (geometry/distance.h), so each is smooth.
#pragma once

#include <stark/mechanics/define.h>

namespace stark::models {

inline Scalar point_point_distance(const Vec3& p, const Vec3& q) { return norm(p - q); }

/// Distance of p to the line through a and b.
inline Scalar point_edge_distance(const Vec3& p, const Vec3& a, const Vec3& b) {
  return norm(cross(a - p, b - p)) / norm(b - a);
}

/// Distance of p to the plane through a, b and c.
inline Scalar point_triangle_distance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = cross(b - a, c - a);
  return abs(dot(p - a, normal)) / norm(normal);
}

/// Distance of the lines through a0, a1 and b0, b1.
inline Scalar edge_edge_distance(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1) {
  const Vec3 normal = cross(a1 - a0, b1 - b0);
  return abs(dot(b0 - a0, normal)) / norm(normal);
}

}  // namespace stark::models
