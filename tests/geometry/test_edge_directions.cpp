// Directions without edges: grids of right triangles, with parallel and with alternating diagonals,
// equilateral triangles, one triangle, folded sheets.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <stark/geometry/edge_directions.h>

using namespace stark;

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

struct Grid {
  std::vector<Vec3> vertices;
  std::vector<Index3> triangles;
};

/// Cells of a unit square; `alternating` diagonals or parallel ones; y leans by `lean`.
Grid grid(int n, bool alternating, double lean, double height) {
  Grid result;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) result.vertices.push_back({i + lean * j, height * j, 0.0});
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 2, d = a + n + 1;
      if (alternating && (i + j) % 2 == 1) {
        result.triangles.push_back({a, b, c});
        result.triangles.push_back({a, c, d});
      } else {
        result.triangles.push_back({a, b, d});
        result.triangles.push_back({b, c, d});
      }
    }
  return result;
}

/// Triangles with this gap [deg].
int64_t count_of(double degrees, const Grid& mesh) {
  const std::vector<double> gaps = compute_direction_gaps(mesh.vertices, mesh.triangles);
  return std::ranges::count_if(gaps, [&](double gap) { return std::fabs(gap - degrees * kDegree) < 1e-12; });
}

}  // namespace

TEST_CASE("parallel diagonals leave a quarter turn, alternating ones an eighth but in the corners") {
  const Grid parallel = grid(4, false, 0.0, 1.0);
  for (const double gap : compute_direction_gaps(parallel.vertices, parallel.triangles))
    CHECK(gap == doctest::Approx(90.0 * kDegree).epsilon(1e-12));
  CHECK(count_of(45.0, grid(4, true, 0.0, 1.0)) == 28);
  CHECK(count_of(90.0, grid(4, true, 0.0, 1.0)) == 4);
}

TEST_CASE("equilateral triangles leave sixty degrees, one triangle its largest angle at most") {
  const Grid even = grid(3, false, 0.5, std::sqrt(0.75));
  for (const double gap : compute_direction_gaps(even.vertices, even.triangles))
    CHECK(gap == doctest::Approx(60.0 * kDegree).epsilon(1e-12));
  const std::vector<Vec3> p{{0, 0, 0}, {2, 0, 0}, {1, 1, 0}};
  CHECK(compute_direction_gaps(p, std::vector<Index3>{{0, 1, 2}})[0] ==
        doctest::Approx(90.0 * kDegree).epsilon(1e-12));
}

TEST_CASE("folds do not matter, nor how triangles wind") {
  Grid folded = grid(2, true, 0.0, 1.0);
  for (Vec3& v : folded.vertices)
    if (v.x > 1.0) v = {1.0, v.y, v.x - 1.0};
  std::swap(folded.triangles[3][0], folded.triangles[3][1]);
  CHECK(count_of(45.0, folded) == count_of(45.0, grid(2, true, 0.0, 1.0)));
  CHECK(count_of(45.0, folded) == 4);
}
