// See edge_directions.h.
#include <stark/geometry/edge_directions.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <stark/geometry/topology.h>

namespace stark {

namespace {

struct PlaneVector {
  double x, y;
};

/// The vertex beyond the edge from p to q of a triangle with the third vertex r, turned about the edge into
/// the plane of the triangle, on the other side of the edge: in the frame of the edge, from p.
PlaneVector unfolded(const Vec3& p, const Vec3& q, const Vec3& beyond) {
  const Vec3 axis = (q - p) / norm(q - p);
  const double along = dot(beyond - p, axis);
  return {along, -norm(beyond - p - axis * along)};
}

/// Angle of a vector as a line, in [0, pi).
double line_angle(double angle) {
  const double turned = std::fmod(angle, std::numbers::pi);
  return turned < 0.0 ? turned + std::numbers::pi : turned;
}

double largest_gap(std::vector<double>& angles) {
  std::ranges::sort(angles);
  double gap = angles.front() + std::numbers::pi - angles.back();
  for (size_t k = 1; k < angles.size(); ++k) gap = std::max(gap, angles[k] - angles[k - 1]);
  return gap;
}

/// Angles of the edges of a triangle, counter-clockwise, against its first one.
std::array<double, 3> edge_angles(const std::array<Vec3, 3>& p) {
  std::array<double, 3> angles{};
  for (int k = 1; k < 3; ++k) {
    const Vec3 before = p[k] - p[k - 1], after = p[(k + 1) % 3] - p[k];
    angles[k] = angles[k - 1] + std::atan2(norm(cross(before, after)), dot(before, after));
  }
  return angles;
}

}  // namespace

std::vector<double> compute_direction_gaps(std::span<const Vec3> vertices,
                                           std::span<const Index3> triangles) {
  std::vector<std::vector<double>> angles(triangles.size());
  const auto corners = [&](int32_t t) {
    const Index3& v = triangles[t];
    return std::array<Vec3, 3>{vertices[v[0]], vertices[v[1]], vertices[v[2]]};
  };
  for (size_t t = 0; t < triangles.size(); ++t)
    for (const double angle : edge_angles(corners(static_cast<int32_t>(t))))
      angles[t].push_back(line_angle(angle));

  const EdgeTriangles around = find_edge_triangles(triangles);
  for (size_t e = 0; e < around.edges.size(); ++e)
    for (int32_t i = around.offsets[e]; i < around.offsets[e + 1]; ++i) {
      const int32_t t = around.triangles[i];
      const std::array<double, 3> own = edge_angles(corners(t));
      int k = 0;  // the edge of t, from its vertex k to the next one
      while (triangles[t][(k + 2) % 3] == around.edges[e][0] ||
             triangles[t][(k + 2) % 3] == around.edges[e][1])
        ++k;
      const Vec3 p = corners(t)[k], q = corners(t)[(k + 1) % 3];
      for (int32_t j = around.offsets[e]; j < around.offsets[e + 1]; ++j) {
        if (j == i) continue;
        for (const int32_t v : triangles[around.triangles[j]]) {
          if (v == around.edges[e][0] || v == around.edges[e][1]) continue;
          const PlaneVector o = unfolded(p, q, vertices[v]);
          angles[t].push_back(line_angle(own[k] + std::atan2(o.y, o.x)));
          angles[t].push_back(line_angle(own[k] + std::atan2(o.y, o.x - norm(q - p))));
        }
      }
    }

  std::vector<double> gaps;
  for (std::vector<double>& of_triangle : angles) gaps.push_back(largest_gap(of_triangle));
  return gaps;
}

}  // namespace stark
