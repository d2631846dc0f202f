// Winding numbers: closed surfaces, holes, pieces, the tree against the sum over all triangles.
#include <doctest/doctest.h>

#include <cmath>

#include <stark/geometry/shapes.h>
#include <stark/geometry/winding_number.h>
#include <support/random_points.h>

using namespace stark;
using namespace stark::test;

TEST_CASE("winding numbers are 1 inside and 0 outside of a closed surface, far and near") {
  const TriangleMesh ball = make_icosphere(1.0, 4);
  const WindingNumber winding(ball.vertices, ball.triangles);
  RandomPoints random(1);
  double worst = 0.0;
  for (int k = 0; k < 2000; ++k) {
    const Vec3 x = random.point() * 3.0;
    if (std::fabs(norm(x) - 1.0) < 0.02) continue;
    worst = std::fmax(worst, std::fabs(winding.at(x) - (norm(x) < 1.0 ? 1.0 : 0.0)));
  }
  CHECK(worst < 0.04);  // the error of dipoles at 2.5 times their reach
}

TEST_CASE("winding numbers of a surface with a hole are above one half inside, of a reversed one negative") {
  TriangleMesh ball = make_icosphere(1.0, 3);
  std::erase_if(ball.triangles, [&](const Index3& t) { return ball.vertices[t[0]].z > 0.8; });
  const WindingNumber winding(ball.vertices, ball.triangles);
  // A cap of height h = 0.2 is 2 pi h of 4 pi; seen from the middle that is what is missing.
  CHECK(winding.at({}) == doctest::Approx(0.9).epsilon(0.02));
  CHECK(winding.at({0.0, 0.0, 0.5}) > 0.5);
  CHECK(winding.at({0.0, 0.0, 2.0}) < 0.5);
  for (Index3& t : ball.triangles) std::swap(t[0], t[1]);
  CHECK(WindingNumber(ball.vertices, ball.triangles).at({}) == doctest::Approx(-winding.at({})));
  CHECK(WindingNumber({}, {}).at({}) == 0.0);
}
