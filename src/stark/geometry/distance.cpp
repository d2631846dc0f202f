// Closest features and distances. See distance.h.
#include <stark/geometry/distance.h>

#include <algorithm>
#include <cmath>

namespace stark {

namespace {

// Squared sine below which two directions count as parallel: their cross product is then mostly rounding
// error.
constexpr double kParallelSine2 = 1e-20;

double clamp01(double t) { return t < 0.0 ? 0.0 : (t > 1.0 ? 1.0 : t); }

double line_parameter(const Vec3& p, const Vec3& e0, const Vec3& e1) {
  const Vec3 e = e1 - e0;
  const double length2 = squared_norm(e);
  return length2 > 0.0 ? dot(p - e0, e) / length2 : 0.0;
}

// Triangle without area: the closest of its edges decides.
PointTriangleType degenerate_point_triangle_type(const Vec3& p, const Vec3& t0, const Vec3& t1,
                                                 const Vec3& t2) {
  const Vec3* corners[4] = {&t0, &t1, &t2, &t0};
  PointTriangleType best = PointTriangleType::P_T0;
  double best_distance = HUGE_VAL;
  for (int k = 0; k < 3; ++k) {
    const PointEdgeType type = point_edge_type(p, *corners[k], *corners[k + 1]);
    const double distance = point_edge_squared_distance(p, *corners[k], *corners[k + 1], type);
    if (distance < best_distance) {
      best_distance = distance;
      const int value = type == PointEdgeType::P_E0 ? k : (type == PointEdgeType::P_E1 ? (k + 1) % 3 : 3 + k);
      best = static_cast<PointTriangleType>(value);
    }
  }
  return best;
}

// Parallel or degenerate edges: one of the end points is always among the closest points.
EdgeEdgeType parallel_edge_edge_type(const Vec3& ea0, const Vec3& ea1, const Vec3& eb0, const Vec3& eb1) {
  EdgeEdgeType best = EdgeEdgeType::EA0_EB0;
  double best_distance = HUGE_VAL;
  const auto consider = [&](const Vec3& p, const Vec3& e0, const Vec3& e1, const EdgeEdgeType(&types)[3]) {
    const PointEdgeType type = point_edge_type(p, e0, e1);
    const double distance = point_edge_squared_distance(p, e0, e1, type);
    if (distance < best_distance) {
      best_distance = distance;
      best = types[static_cast<int>(type)];
    }
  };
  using enum EdgeEdgeType;
  consider(ea0, eb0, eb1, {EA0_EB0, EA0_EB1, EA0_EB});
  consider(ea1, eb0, eb1, {EA1_EB0, EA1_EB1, EA1_EB});
  consider(eb0, ea0, ea1, {EA0_EB0, EA1_EB0, EA_EB0});
  consider(eb1, ea0, ea1, {EA0_EB1, EA1_EB1, EA_EB1});
  return best;
}

}  // namespace

PointEdgeType point_edge_type(const Vec3& p, const Vec3& e0, const Vec3& e1) {
  const Vec3 e = e1 - e0;
  if (!(dot(p - e0, e) > 0.0)) return PointEdgeType::P_E0;
  if (!(dot(p - e1, e) < 0.0)) return PointEdgeType::P_E1;
  return PointEdgeType::P_E;
}

PointTriangleType point_triangle_type(const Vec3& p, const Vec3& t0, const Vec3& t1, const Vec3& t2) {
  using enum PointTriangleType;
  const Vec3 ab = t1 - t0, ac = t2 - t0, bc = t2 - t1;
  const Vec3 normal = cross(ab, ac);
  if (!(squared_norm(normal) > kParallelSine2 * squared_norm(ab) * squared_norm(ac))) {
    return degenerate_point_triangle_type(p, t0, t1, t2);
  }
  const Vec3 ap = p - t0, bp = p - t1, cp = p - t2;
  const double a_ab = dot(ap, ab), a_ac = dot(ap, ac);
  if (a_ab <= 0.0 && a_ac <= 0.0) return P_T0;
  const double b_ab = dot(bp, ab), b_bc = dot(bp, bc);
  if (b_ab >= 0.0 && b_bc <= 0.0) return P_T1;
  const double c_ac = dot(cp, ac), c_bc = dot(cp, bc);
  if (c_ac >= 0.0 && c_bc >= 0.0) return P_T2;
  // ab x normal points out of the triangle across t0t1, and so on around.
  if (a_ab > 0.0 && b_ab < 0.0 && dot(cross(ab, normal), ap) >= 0.0) return P_E0;
  if (b_bc > 0.0 && c_bc < 0.0 && dot(cross(bc, normal), bp) >= 0.0) return P_E1;
  if (a_ac > 0.0 && c_ac < 0.0 && dot(cross(normal, ac), ap) >= 0.0) return P_E2;
  return P_T;
}

EdgeEdgeType edge_edge_type(const Vec3& ea0, const Vec3& ea1, const Vec3& eb0, const Vec3& eb1) {
  using enum EdgeEdgeType;
  const Vec3 u = ea1 - ea0, v = eb1 - eb0, w = ea0 - eb0;
  const Vec3 normal = cross(u, v);
  const double uu = squared_norm(u), vv = squared_norm(v), nn = squared_norm(normal);
  if (!(nn > kParallelSine2 * uu * vv)) return parallel_edge_edge_type(ea0, ea1, eb0, eb1);
  const double uv = dot(u, v);
  // Parameter s on line A of the point closest to line B, clamped; t on B follows, and clamping t moves s
  // again.
  const double s_numerator = dot(cross(v, w), normal);  // s = s_numerator / nn
  int s_side = s_numerator <= 0.0 ? 0 : (s_numerator >= nn ? 1 : 2);
  const double s = s_side == 0 ? 0.0 : (s_side == 1 ? 1.0 : s_numerator / nn);
  const double t_numerator = s_side == 1 ? dot(v, ea1 - eb0) : uv * s + dot(v, w);  // t = t_numerator / vv
  if (t_numerator <= 0.0 || t_numerator >= vv) {
    const bool low = t_numerator <= 0.0;
    const PointEdgeType type = point_edge_type(low ? eb0 : eb1, ea0, ea1);
    if (type == PointEdgeType::P_E) return low ? EA_EB0 : EA_EB1;
    if (type == PointEdgeType::P_E0) return low ? EA0_EB0 : EA0_EB1;
    return low ? EA1_EB0 : EA1_EB1;
  }
  return s_side == 0 ? EA0_EB : (s_side == 1 ? EA1_EB : EA_EB);
}

Vec3 common_normal(const Vec3& u, const Vec3& v) {
  Vec3 normal = cross(u, v);
  const double uu = squared_norm(u), vv = squared_norm(v);
  // The rounding error of the product is relative to |u| |v|; its part along u or v is the harmful one,
  // because the primitives extend far in these directions. Projecting it out leaves a tilt that matters only
  // in second order.
  if (squared_norm(normal) < 1e-4 * uu * vv) {
    normal -= u * (dot(normal, u) / uu);
    normal -= v * (dot(normal, v) / vv);
  }
  return normal;
}

double point_point_squared_distance(const Vec3& p, const Vec3& q) { return squared_norm(p - q); }

double point_line_squared_distance(const Vec3& p, const Vec3& e0, const Vec3& e1) {
  const Vec3 e = e1 - e0;
  const double length2 = squared_norm(e);
  if (!(length2 > 0.0)) return squared_norm(p - e0);
  return squared_norm(cross(p - e0, e)) / length2;
}

double point_plane_squared_distance(const Vec3& p, const Vec3& t0, const Vec3& t1, const Vec3& t2) {
  const Vec3 normal = common_normal(t1 - t0, t2 - t0);
  const double height = dot(p - t0, normal);
  return height * height / squared_norm(normal);
}

double line_line_squared_distance(const Vec3& ea0, const Vec3& ea1, const Vec3& eb0, const Vec3& eb1) {
  const Vec3 normal = common_normal(ea1 - ea0, eb1 - eb0);
  const double height = dot(ea0 - eb0, normal);
  return height * height / squared_norm(normal);
}

double point_edge_squared_distance(const Vec3& p, const Vec3& e0, const Vec3& e1, PointEdgeType type) {
  switch (type) {
    case PointEdgeType::P_E0:
      return point_point_squared_distance(p, e0);
    case PointEdgeType::P_E1:
      return point_point_squared_distance(p, e1);
    case PointEdgeType::P_E:
      break;
  }
  return point_line_squared_distance(p, e0, e1);
}

double point_triangle_squared_distance(const Vec3& p, const Vec3& t0, const Vec3& t1, const Vec3& t2,
                                       PointTriangleType type) {
  using enum PointTriangleType;
  switch (type) {
    case P_T0:
      return point_point_squared_distance(p, t0);
    case P_T1:
      return point_point_squared_distance(p, t1);
    case P_T2:
      return point_point_squared_distance(p, t2);
    case P_E0:
      return point_line_squared_distance(p, t0, t1);
    case P_E1:
      return point_line_squared_distance(p, t1, t2);
    case P_E2:
      return point_line_squared_distance(p, t2, t0);
    case P_T:
      break;
  }
  return point_plane_squared_distance(p, t0, t1, t2);
}

double edge_edge_squared_distance(const Vec3& ea0, const Vec3& ea1, const Vec3& eb0, const Vec3& eb1,
                                  EdgeEdgeType type) {
  using enum EdgeEdgeType;
  switch (type) {
    case EA0_EB0:
      return point_point_squared_distance(ea0, eb0);
    case EA0_EB1:
      return point_point_squared_distance(ea0, eb1);
    case EA1_EB0:
      return point_point_squared_distance(ea1, eb0);
    case EA1_EB1:
      return point_point_squared_distance(ea1, eb1);
    case EA_EB0:
      return point_line_squared_distance(eb0, ea0, ea1);
    case EA_EB1:
      return point_line_squared_distance(eb1, ea0, ea1);
    case EA0_EB:
      return point_line_squared_distance(ea0, eb0, eb1);
    case EA1_EB:
      return point_line_squared_distance(ea1, eb0, eb1);
    case EA_EB:
      break;
  }
  return line_line_squared_distance(ea0, ea1, eb0, eb1);
}

double point_edge_squared_distance(const Vec3& p, const Vec3& e0, const Vec3& e1) {
  return point_edge_squared_distance(p, e0, e1, point_edge_type(p, e0, e1));
}

double point_triangle_squared_distance(const Vec3& p, const Vec3& t0, const Vec3& t1, const Vec3& t2) {
  return point_triangle_squared_distance(p, t0, t1, t2, point_triangle_type(p, t0, t1, t2));
}

double edge_edge_squared_distance(const Vec3& ea0, const Vec3& ea1, const Vec3& eb0, const Vec3& eb1) {
  return edge_edge_squared_distance(ea0, ea1, eb0, eb1, edge_edge_type(ea0, ea1, eb0, eb1));
}

std::array<double, 2> point_edge_weights(const Vec3& p, const Vec3& e0, const Vec3& e1, PointEdgeType type) {
  if (type == PointEdgeType::P_E0) return {1.0, 0.0};
  if (type == PointEdgeType::P_E1) return {0.0, 1.0};
  const double t = clamp01(line_parameter(p, e0, e1));
  return {1.0 - t, t};
}

std::array<double, 3> point_triangle_weights(const Vec3& p, const Vec3& t0, const Vec3& t1, const Vec3& t2,
                                             PointTriangleType type) {
  using enum PointTriangleType;
  switch (type) {
    case P_T0:
      return {1.0, 0.0, 0.0};
    case P_T1:
      return {0.0, 1.0, 0.0};
    case P_T2:
      return {0.0, 0.0, 1.0};
    case P_E0: {
      const double t = clamp01(line_parameter(p, t0, t1));
      return {1.0 - t, t, 0.0};
    }
    case P_E1: {
      const double t = clamp01(line_parameter(p, t1, t2));
      return {0.0, 1.0 - t, t};
    }
    case P_E2: {
      const double t = clamp01(line_parameter(p, t2, t0));
      return {t, 0.0, 1.0 - t};
    }
    case P_T:
      break;
  }
  const Vec3 ab = t1 - t0, ac = t2 - t0, ap = p - t0;
  const Vec3 normal = cross(ab, ac);
  const double nn = squared_norm(normal);
  const double w1 = clamp01(dot(cross(ap, ac), normal) / nn);
  const double w2 = std::min(std::max(dot(cross(ab, ap), normal) / nn, 0.0), 1.0 - w1);
  return {1.0 - w1 - w2, w1, w2};
}

std::array<double, 4> edge_edge_weights(const Vec3& ea0, const Vec3& ea1, const Vec3& eb0, const Vec3& eb1,
                                        EdgeEdgeType type) {
  using enum EdgeEdgeType;
  double s = 0.0, t = 0.0;
  switch (type) {
    case EA0_EB0:
      break;
    case EA0_EB1:
      t = 1.0;
      break;
    case EA1_EB0:
      s = 1.0;
      break;
    case EA1_EB1:
      s = t = 1.0;
      break;
    case EA_EB0:
      s = line_parameter(eb0, ea0, ea1);
      break;
    case EA_EB1:
      s = line_parameter(eb1, ea0, ea1), t = 1.0;
      break;
    case EA0_EB:
      t = line_parameter(ea0, eb0, eb1);
      break;
    case EA1_EB:
      t = line_parameter(ea1, eb0, eb1), s = 1.0;
      break;
    case EA_EB: {
      const Vec3 u = ea1 - ea0, v = eb1 - eb0, w = ea0 - eb0;
      const Vec3 normal = cross(u, v);
      s = clamp01(dot(cross(v, w), normal) / squared_norm(normal));
      t = (dot(u, v) * s + dot(v, w)) / squared_norm(v);
      break;
    }
  }
  s = clamp01(s);
  t = clamp01(t);
  return {1.0 - s, s, 1.0 - t, t};
}

}  // namespace stark
