// See winding_number.h.
#include <stark/geometry/winding_number.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stark {

namespace {

constexpr int32_t kLeafTriangles = 8;

/// Distance over reach from which triangles count as a dipole: numbers are off by 0.03 at most, far from one
/// half.
constexpr double kFar = 2.5;

Vec3 area_vector(const std::array<Vec3, 3>& t) { return cross(t[1] - t[0], t[2] - t[0]) * 0.5; }

Vec3 centroid(const std::array<Vec3, 3>& t) { return (t[0] + t[1] + t[2]) * (1.0 / 3.0); }

/// Solid angle of a triangle seen from a point [van Oosterom, Strackee 1983].
double solid_angle(const std::array<Vec3, 3>& t, const Vec3& point) {
  const Vec3 a = t[0] - point, b = t[1] - point, c = t[2] - point;
  const double la = norm(a), lb = norm(b), lc = norm(c);
  const double volume = dot(a, cross(b, c));
  const double denominator = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
  return volume == 0.0 && denominator <= 0.0 ? 0.0 : 2.0 * std::atan2(volume, denominator);
}

}  // namespace

WindingNumber::WindingNumber(std::span<const Vec3> vertices, std::span<const Index3> triangles) {
  for (const auto& [i, j, k] : triangles) triangles_.push_back({vertices[i], vertices[j], vertices[k]});
  if (!triangles_.empty()) build(0, static_cast<int32_t>(triangles_.size()));
}

void WindingNumber::build(int32_t first, int32_t last) {
  const size_t number = nodes_.size();
  nodes_.emplace_back();
  Node node{.first = first, .last = last};
  Vec3 low = centroid(triangles_[first]), high = low, weighted;
  double total = 0.0;
  for (int32_t t = first; t < last; ++t) {
    const Vec3 c = centroid(triangles_[t]), area = area_vector(triangles_[t]);
    for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], c[k]), high[k] = std::max(high[k], c[k]);
    node.area += area;
    weighted += c * norm(area);
    total += norm(area);
  }
  node.centre = total > 0.0 ? weighted / total : low;
  for (int32_t t = first; t < last; ++t)
    for (const Vec3& v : triangles_[t]) node.reach = std::max(node.reach, norm(v - node.centre));
  if (last - first > kLeafTriangles) {
    const Vec3 size = high - low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
    const int32_t middle = first + (last - first) / 2;
    std::nth_element(triangles_.begin() + first, triangles_.begin() + middle, triangles_.begin() + last,
                     [&](const auto& a, const auto& b) { return centroid(a)[axis] < centroid(b)[axis]; });
    build(first, middle);
    node.right = static_cast<int32_t>(nodes_.size());
    build(middle, last);
  }
  nodes_[number] = node;
}

double WindingNumber::at(const Vec3& point) const {
  if (nodes_.empty()) return 0.0;
  double sum = 0.0;
  std::array<int32_t, 64> open;
  int count = 0;
  open[count++] = 0;
  while (count > 0) {
    const int32_t n = open[--count];
    const Node& node = nodes_[n];
    const Vec3 way = node.centre - point;
    const double distance = norm(way);
    if (distance > kFar * node.reach && distance > 0.0) {
      sum += dot(node.area, way) / (distance * distance * distance);
    } else if (node.right < 0) {
      for (int32_t t = node.first; t < node.last; ++t) sum += solid_angle(triangles_[t], point);
    } else {
      open[count++] = node.right;
      open[count++] = n + 1;
    }
  }
  return sum / (4.0 * std::numbers::pi);
}

}  // namespace stark
