#include <stark/geometry/polyline.h>

#include <cmath>

namespace stark {

namespace {

/// The coordinate axis with the smallest component along t, made perpendicular to it.
Vec3 default_normal(const Vec3& t) {
  const double x = std::fabs(t.x), y = std::fabs(t.y), z = std::fabs(t.z);
  if (x <= y && x <= z) return {1, 0, 0};
  return y <= z ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
}

Mat3 frame_of(const Vec3& tangent, const Vec3& normal) {
  const Vec3 d1 = normalized(normal - tangent * dot(normal, tangent));
  return Mat3::from_columns(d1, cross(tangent, d1), tangent);
}

/// v turned by the smallest rotation that takes unit vector a to b.
Vec3 transported(const Vec3& v, const Vec3& a, const Vec3& b) {
  const Vec3 axis = cross(a, b);
  return v * dot(a, b) + cross(axis, v) + axis * (dot(axis, v) / (1.0 + dot(a, b)));
}

}  // namespace

std::vector<double> polyline_lengths(std::span<const Vec3> points) {
  std::vector<double> lengths;
  for (size_t i = 0; i + 1 < points.size(); ++i) lengths.push_back(norm(points[i + 1] - points[i]));
  return lengths;
}

std::vector<Vec3> polyline_tangents(std::span<const Vec3> points) {
  std::vector<Vec3> tangents;
  for (size_t i = 0; i < points.size(); ++i) {
    Vec3 sum;
    if (i > 0) sum += normalized(points[i] - points[i - 1]);
    if (i + 1 < points.size()) sum += normalized(points[i + 1] - points[i]);
    tangents.push_back(normalized(sum));
  }
  return tangents;
}

std::vector<Mat3> polyline_frames(std::span<const Vec3> points, const std::optional<Vec3>& normal) {
  const std::vector<Vec3> tangents = polyline_tangents(points);
  std::vector<Mat3> frames{frame_of(tangents[0], normal.value_or(default_normal(tangents[0])))};
  for (size_t i = 1; i < points.size(); ++i)
    frames.push_back(
        frame_of(tangents[i], transported(frames.back().column(0), tangents[i - 1], tangents[i])));
  return frames;
}

std::vector<Vec3> straightened(std::span<const Vec3> points, const Vec3& direction) {
  std::vector<Vec3> result{points[0]};
  for (const double length : polyline_lengths(points)) result.push_back(result.back() + direction * length);
  return result;
}

}  // namespace stark
