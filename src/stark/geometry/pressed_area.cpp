#include <stark/geometry/pressed_area.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace stark {

namespace {

struct Point {
  double u = 0.0, v = 0.0;
};
using Polygon = std::vector<Point>;  ///< convex, counterclockwise

Point operator-(const Point& a, const Point& b) { return {a.u - b.u, a.v - b.v}; }
double cross(const Point& a, const Point& b) { return a.u * b.v - a.v * b.u; }
double length(const Point& a) { return std::sqrt(a.u * a.u + a.v * a.v); }

/// Grows with the angle to the first axis, from -2 to 2.
double turn_of(const Point& a) {
  const double sum = std::fabs(a.u) + std::fabs(a.v);
  return sum > 0.0 ? std::copysign(1.0 - a.u / sum, a.v) : 0.0;
}

/// Part of its size by which a face may miss being convex, or a corner being at a border.
constexpr double kRounding = 1e-9;

/// Squared sine of the angle between edges up to which they count as almost parallel, as in contact.
constexpr double kParallel = 1e-3;

/// Tangents of the plane of a unit normal, through an origin.
struct Plane {
  Vec3 origin, first, second;

  Plane(const Vec3& from, const Vec3& normal) : origin(from) {
    const Vec3 axis = std::fabs(normal.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    first = normalized(axis - normal * dot(normal, axis));
    second = stark::cross(normal, first);
  }
  Point flat(const Vec3& x) const { return {dot(x - origin, first), dot(x - origin, second)}; }
  Vec3 spatial(const Point& p) const { return origin + first * p.u + second * p.v; }
};

double size_of(const Polygon& polygon) {
  double size = 0.0;
  for (const Point& p : polygon) size = std::max(size, length(p - polygon[0]));
  return size;
}

/// Empty where it is not convex.
Polygon polygon_of(std::span<const Vec3> corners, const Plane& plane) {
  Polygon polygon;
  Point mean;
  for (const Vec3& x : corners) {
    polygon.push_back(plane.flat(x));
    mean.u += polygon.back().u / static_cast<double>(corners.size());
    mean.v += polygon.back().v / static_cast<double>(corners.size());
  }
  std::ranges::sort(polygon, {}, [&](const Point& p) { return turn_of(p - mean); });
  const double size = size_of(polygon);
  const size_t n = polygon.size();
  for (size_t k = 0; k < n; ++k) {
    const Point along = polygon[(k + 1) % n] - polygon[k], next = polygon[(k + 2) % n] - polygon[(k + 1) % n];
    if (cross(along, next) < -kRounding * size * size) return {};
  }
  return polygon;
}

/// The part of a polygon on the left of the line from a to b [Sutherland and Hodgman 1974].
Polygon left_of(const Polygon& polygon, const Point& a, const Point& b) {
  Polygon kept;
  for (size_t k = 0; k < polygon.size(); ++k) {
    const Point &p = polygon[k], &q = polygon[(k + 1) % polygon.size()];
    const double at_p = cross(b - a, p - a), at_q = cross(b - a, q - a);
    if (at_p >= 0.0) kept.push_back(p);
    if ((at_p > 0.0 && at_q < 0.0) || (at_p < 0.0 && at_q > 0.0)) {
      const double t = at_p / (at_p - at_q);
      kept.push_back({p.u + (q.u - p.u) * t, p.v + (q.v - p.v) * t});
    }
  }
  return kept;
}

bool lies_inside(const Polygon& polygon, const Polygon& other) {
  const double margin = kRounding * size_of(other);
  for (size_t k = 0; k < other.size(); ++k) {
    const Point along = other[(k + 1) % other.size()] - other[k];
    for (const Point& p : polygon)
      if (!(cross(along, p - other[k]) > margin * length(along))) return false;
  }
  return true;
}

double area_of(const Polygon& polygon) {
  double twice = 0.0;
  for (size_t k = 2; k < polygon.size(); ++k)
    twice += cross(polygon[k - 1] - polygon[0], polygon[k] - polygon[0]);
  return 0.5 * twice;
}

Point centre_of(const Polygon& polygon, double area) {
  Point sum;
  for (size_t k = 2; k < polygon.size(); ++k) {
    const Point a = polygon[k - 1] - polygon[0], b = polygon[k] - polygon[0];
    const double share = 0.5 * cross(a, b) / area;
    sum.u += share * (a.u + b.u) / 3.0;
    sum.v += share * (a.v + b.v) / 3.0;
  }
  return {polygon[0].u + sum.u, polygon[0].v + sum.v};
}

/// Integral of the distance from the centre over the triangle of the centre and an edge from a to b, with the
/// closed form of that of sec^3 [m^3].
double integral_of_distance(const Point& a, const Point& b) {
  const double edge = length(b - a), height = cross(a, b) / edge;
  if (!(edge > 0.0 && height > 0.0)) return 0.0;
  const auto primitive = [&](const Point& p) {
    const double u = (p.u * (b.u - a.u) + p.v * (b.v - a.v)) / edge;
    return height * (u * std::hypot(u, height) + height * height * std::asinh(u / height)) / 6.0;
  };
  return primitive(b) - primitive(a);
}

/// How much a corner carries between two edges of these directions: where edges cross that are almost
/// parallel, as little as their contact does [theory eq. 17].
double bearing(const Point& before, const Point& after) {
  const double sine = cross(before, after) / (length(before) * length(after));
  const double c = sine * sine / kParallel;
  return c < 1.0 ? c * (2.0 - c) : 1.0;
}

/// Mean distance of the points over that of the corners, which share the pressure by the length of their
/// edges.
double part_of(const Polygon& polygon, const Point& centre, double area) {
  const size_t n = polygon.size();
  double of_points = 0.0, of_corners = 0.0, sum = 0.0;
  for (size_t k = 0; k < n; ++k) {
    const Point corner = polygon[k] - centre, next = polygon[(k + 1) % n] - centre;
    const Point before = polygon[k] - polygon[(k + n - 1) % n], after = next - corner;
    of_points += integral_of_distance(corner, next);
    if (!(length(before) > 0.0 && length(after) > 0.0)) continue;
    const double share = (length(before) + length(after)) * bearing(before, after);
    of_corners += share * length(corner);
    sum += share;
  }
  return of_corners > 0.0 ? std::min(1.0, of_points / area / (of_corners / sum)) : 1.0;
}

}  // namespace

std::optional<PressedArea> find_pressed_area(std::span<const Vec3> face, std::span<const Vec3> other,
                                             const Vec3& normal) {
  if (face.size() < 3 || other.size() < 3) return {};
  const Plane plane(face[0], normal);
  const Polygon of_face = polygon_of(face, plane), of_other = polygon_of(other, plane);
  if (of_face.empty() || of_other.empty()) return {};
  Polygon both = of_face;
  for (size_t k = 0; k < of_other.size() && both.size() > 2; ++k)
    both = left_of(both, of_other[k], of_other[(k + 1) % of_other.size()]);
  const double smaller = std::min(area_of(of_face), area_of(of_other)), area = area_of(both);
  if (!(area > kRounding * smaller)) return {};
  const Point centre = centre_of(both, area);
  return PressedArea{.centre = plane.spatial(centre),
                     .part = part_of(both, centre, area),
                     .of_smaller = area / smaller,
                     .is_inside = lies_inside(of_face, of_other)};
}

}  // namespace stark
