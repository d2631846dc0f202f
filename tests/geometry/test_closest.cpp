// Closest triangles: against all distances, ties, no triangles.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include <stark/geometry/closest.h>
#include <stark/geometry/distance.h>
#include <stark/geometry/shapes.h>

using namespace stark;

TEST_CASE("the closest triangle is the first of those with the smallest distance") {
  const TriangleMesh mesh = make_box({0.3, 0.2, 0.1}, 5);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(-0.3, 0.3);
  std::vector<Vec3> points;
  for (int i = 0; i < 200; ++i)
    points.push_back({coordinate(random), coordinate(random), coordinate(random)});
  points.push_back(mesh.vertices[3]);
  const std::vector<ClosestTriangle> closest = find_closest_triangles(points, mesh.vertices, mesh.triangles);
  REQUIRE(closest.size() == points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    int32_t expected = -1;
    double smallest = std::numeric_limits<double>::infinity();
    for (size_t k = 0; k < mesh.triangles.size(); ++k) {
      const Index3& t = mesh.triangles[k];
      const double squared = point_triangle_squared_distance(points[i], mesh.vertices[t[0]],
                                                             mesh.vertices[t[1]], mesh.vertices[t[2]]);
      if (squared < smallest) smallest = squared, expected = static_cast<int32_t>(k);
    }
    CHECK(closest[i].triangle == expected);
    CHECK(closest[i].distance == std::sqrt(smallest));
  }
  CHECK(closest.back().distance == 0.0);
}

TEST_CASE("a point without triangles has none") {
  const std::vector<Vec3> points{{0, 0, 0}};
  const std::vector<ClosestTriangle> closest = find_closest_triangles(points, {}, {});
  CHECK(closest.front().triangle == -1);
  CHECK(std::isinf(closest.front().distance));
}
