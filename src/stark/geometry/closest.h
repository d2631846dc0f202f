// Closest triangles of a surface to points. Phase: scene description.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include <stark/geometry/mesh.h>

namespace stark {

struct ClosestTriangle {
  int32_t triangle = -1;                                      ///< -1: no triangles
  double distance = std::numeric_limits<double>::infinity();  ///< [m]
};

/// The triangle closest to each point, the first one of several. O(points * triangles), most of them passed
/// over in blocks.
std::vector<ClosestTriangle> find_closest_triangles(std::span<const Vec3> points,
                                                    std::span<const Vec3> vertices,
                                                    std::span<const Index3> triangles);

}  // namespace stark
