#include <stark/geometry/closest.h>

#include <algorithm>
#include <cmath>

#include <stark/geometry/distance.h>

namespace stark {

namespace {

struct Box {
  Vec3 low, high;
};

Box merge(const Box& a, const Box& b) {
  return {{std::min(a.low.x, b.low.x), std::min(a.low.y, b.low.y), std::min(a.low.z, b.low.z)},
          {std::max(a.high.x, b.high.x), std::max(a.high.y, b.high.y), std::max(a.high.z, b.high.z)}};
}

Box box_of(std::span<const Vec3> x, const Index3& t) {
  return merge({x[t[0]], x[t[0]]}, merge({x[t[1]], x[t[1]]}, {x[t[2]], x[t[2]]}));
}

double squared_distance(const Vec3& p, const Box& box) {
  const auto outside = [](double value, double low, double high) {
    return std::max(std::max(low - value, value - high), 0.0);
  };
  return squared_norm({outside(p.x, box.low.x, box.high.x), outside(p.y, box.low.y, box.high.y),
                       outside(p.z, box.low.z, box.high.z)});
}

}  // namespace

std::vector<ClosestTriangle> find_closest_triangles(std::span<const Vec3> points,
                                                    std::span<const Vec3> vertices,
                                                    std::span<const Index3> triangles) {
  // Boxes of triangles and of blocks of them: neighbours in a mesh mostly follow each other.
  constexpr size_t kBlock = 32;
  std::vector<Box> boxes, blocks;
  for (size_t k = 0; k < triangles.size(); ++k) {
    boxes.push_back(box_of(vertices, triangles[k]));
    if (k % kBlock == 0)
      blocks.push_back(boxes.back());
    else
      blocks.back() = merge(blocks.back(), boxes.back());
  }
  std::vector<ClosestTriangle> result(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    double closest = std::numeric_limits<double>::infinity();
    for (size_t k = 0; k < triangles.size(); ++k) {
      if (k % kBlock == 0 && !(squared_distance(points[i], blocks[k / kBlock]) < closest)) {
        k += kBlock - 1;
        continue;
      }
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
