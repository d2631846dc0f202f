#include <stark/geometry/closest.h>

#include <algorithm>
#include <cmath>

#include <stark/geometry/distance.h>

namespace stark {

namespace {

struct Box {
  Vec3 low, high;
};

Box box_of(std::span<const Vec3> x, const Index3& t) {
  Box box{x[t[0]], x[t[0]]};
  for (const int32_t v : t) {
    box.low = {std::min(box.low.x, x[v].x), std::min(box.low.y, x[v].y), std::min(box.low.z, x[v].z)};
    box.high = {std::max(box.high.x, x[v].x), std::max(box.high.y, x[v].y), std::max(box.high.z, x[v].z)};
  }
  return box;
}

double squared_distance(const Vec3& p, const Box& box) {
  const auto outside = [](double value, double low, double high) {
    return std::max({low - value, value - high, 0.0});
  };
  return squared_norm({outside(p.x, box.low.x, box.high.x), outside(p.y, box.low.y, box.high.y),
                       outside(p.z, box.low.z, box.high.z)});
}

}  // namespace

std::vector<ClosestTriangle> find_closest_triangles(std::span<const Vec3> points,
                                                    std::span<const Vec3> vertices,
                                                    std::span<const Index3> triangles) {
  std::vector<Box> boxes;
  for (const Index3& t : triangles) boxes.push_back(box_of(vertices, t));
  std::vector<ClosestTriangle> result(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    double closest = std::numeric_limits<double>::infinity();
    for (size_t k = 0; k < triangles.size(); ++k) {
      if (!(squared_distance(points[i], boxes[k]) < closest)) continue;
      const Index3& t = triangles[k];
      const double squared =
          point_triangle_squared_distance(points[i], vertices[t[0]], vertices[t[1]], vertices[t[2]]);
      if (!(squared < closest)) continue;
      closest = squared;
      result[i] = {static_cast<int32_t>(k), std::sqrt(squared)};
    }
  }
  return result;
}

}  // namespace stark
