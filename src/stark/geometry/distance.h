// Closest features and distances between points, segments and triangles: the stencils of contact. The type
// names the open feature that holds the closest point; formulas per type are then smooth. Regions after
// Ericson 2005, "Real-Time Collision Detection", ch. 5.1; parallel and degenerate edges fall back to the best
// point-edge pair. Used by collision detection and by contact in every iteration.
#pragma once

#include <array>
#include <cstdint>

#include <stark/base/math.h>

namespace stark {

enum class PointPointType : uint8_t { P_P };

/// Feature of the edge (e0, e1) that is closest to the point.
enum class PointEdgeType : uint8_t { P_E0, P_E1, P_E };

/// Feature of the triangle (t0, t1, t2) that is closest to the point; edges E0 = t0t1, E1 = t1t2, E2 = t2t0.
enum class PointTriangleType : uint8_t { P_T0, P_T1, P_T2, P_E0, P_E1, P_E2, P_T };

/// Features of the edges A = (ea0, ea1) and B = (eb0, eb1) that hold the closest points.
enum class EdgeEdgeType : uint8_t {
  EA0_EB0,
  EA0_EB1,
  EA1_EB0,
  EA1_EB1,
  EA_EB0,
  EA_EB1,
  EA0_EB,
  EA1_EB,
  EA_EB
};

PointEdgeType point_edge_type(const Vec3& p, const Vec3& e0, const Vec3& e1);
PointTriangleType point_triangle_type(const Vec3& p, const Vec3& t0, const Vec3& t1, const Vec3& t2);
EdgeEdgeType edge_edge_type(const Vec3& ea0, const Vec3& ea1, const Vec3& eb0, const Vec3& eb1);

/// Normal of the plane of two directions: their cross product, for nearly parallel ones corrected so that it
/// stays perpendicular to both within rounding; zero if one of them is zero.
Vec3 common_normal(const Vec3& u, const Vec3& v);

// Squared distances between the features that the type names, points, infinite lines and planes [m^2].
double point_point_squared_distance(const Vec3& p, const Vec3& q);
double point_line_squared_distance(const Vec3& p, const Vec3& e0, const Vec3& e1);
double point_plane_squared_distance(const Vec3& p, const Vec3& t0, const Vec3& t1, const Vec3& t2);
double line_line_squared_distance(const Vec3& ea0, const Vec3& ea1, const Vec3& eb0, const Vec3& eb1);

// Squared distances of the closed primitives [m^2]; the second form takes a type found before.
double point_edge_squared_distance(const Vec3& p, const Vec3& e0, const Vec3& e1);
double point_edge_squared_distance(const Vec3& p, const Vec3& e0, const Vec3& e1, PointEdgeType type);
double point_triangle_squared_distance(const Vec3& p, const Vec3& t0, const Vec3& t1, const Vec3& t2);
double point_triangle_squared_distance(const Vec3& p, const Vec3& t0, const Vec3& t1, const Vec3& t2,
                                       PointTriangleType type);
double edge_edge_squared_distance(const Vec3& ea0, const Vec3& ea1, const Vec3& eb0, const Vec3& eb1);
double edge_edge_squared_distance(const Vec3& ea0, const Vec3& ea1, const Vec3& eb0, const Vec3& eb1,
                                  EdgeEdgeType type);

// Closest points as weights of the vertices; each primitive's weights sum to one.
/// Weights of (e0, e1).
std::array<double, 2> point_edge_weights(const Vec3& p, const Vec3& e0, const Vec3& e1, PointEdgeType type);
/// Weights of (t0, t1, t2).
std::array<double, 3> point_triangle_weights(const Vec3& p, const Vec3& t0, const Vec3& t1, const Vec3& t2,
                                             PointTriangleType type);
/// Weights of (ea0, ea1, eb0, eb1).
std::array<double, 4> edge_edge_weights(const Vec3& ea0, const Vec3& ea1, const Vec3& eb0, const Vec3& eb1,
                                        EdgeEdgeType type);

}  // namespace stark
