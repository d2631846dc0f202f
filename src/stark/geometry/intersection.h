// Exact geometric predicates and the intersection tests built on them. Signs are exact for all inputs whose
// products neither overflow nor underflow (coordinates of magnitude 1e-70 .. 1e70): a floating-point filter
// decides nearly always, otherwise the determinant is evaluated in expansion arithmetic (Shewchuk 1997,
// "Adaptive precision floating-point arithmetic and fast robust geometric predicates"). Used for initial
// checks and to verify accepted steps.
#pragma once

#include <span>

#include <stark/geometry/mesh.h>

namespace stark {

/// Sign (-1, 0, 1) of det[b - a, c - a] for 2D points given by coordinates.
int orient2d(double ax, double ay, double bx, double by, double cx, double cy);

/// Sign (-1, 0, 1) of det[b - a, c - a, d - a]: positive when the tet (a, b, c, d) is positively oriented,
/// that is when d lies on the side of the plane (a, b, c) that its counter-clockwise normal points to.
int orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Whether the closed segment (p, q) meets the closed triangle (a, b, c); touching counts. Exact for
/// triangles of non-zero area, coplanar segments included. For triangles of zero area the test is
/// conservative: true when the projections onto all three coordinate planes overlap.
bool segment_intersects_triangle(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c);

/// Where a segment meets a triangle, up to rounding: in the middle of what they share where it lies in the
/// plane of the triangle. A point of the segment, wherever the triangle is.
Vec3 meeting_point(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c);

enum class PointLocation : uint8_t { Outside, Inside, OnSurface };

/// Location of p relative to the volume enclosed by a closed triangle mesh, by the parity of crossings along
/// a ray with exact predicates; the orientation of the triangles does not matter. Linear in the number of
/// triangles.
PointLocation locate_point(const Vec3& p, std::span<const Vec3> vertices, std::span<const Index3> triangles);

}  // namespace stark
