// The forces that rounding of positions makes.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include <stark/mechanics/force_rounding.h>

using namespace stark;

TEST_CASE("rounding of forces grows with stiffness and with the distance from the origin") {
  BlockMatrix hessian;
  hessian.pattern = BlockPattern::from_pairs(2, {{0, 1}});
  hessian.set_zero();
  for (int64_t slot = 0; slot < 3; ++slot)
    for (int k = 0; k < 3; ++k) hessian.values[9 * slot + 4 * k] = slot == 1 ? -1e6 : 1e6;
  const DofLayout points = DofLayout::build({false, false}, std::vector<bool>{});
  const double eps = std::numeric_limits<double>::epsilon(), norm_of_block = 1e6 * std::sqrt(3.0);
  const std::vector<Vec3> x{{1, 0, 0}, {0, 2, 0}};
  const std::vector<double> noise = force_rounding(hessian, x, points);
  REQUIRE(noise.size() == 2);
  CHECK(noise[0] == doctest::Approx(3.0 * eps * norm_of_block));
  CHECK(noise[1] == doctest::Approx(3.0 * eps * norm_of_block));
  // Of energies: by the size of the element, and by how far it is from the origin.
  const double size = std::sqrt(5.0);
  CHECK(energy_rounding(hessian, x, points) == doctest::Approx(size * (size + 2.0) * eps * norm_of_block));
  const std::vector<Vec3> far{{101, 0, 0}, {100, 2, 0}};
  CHECK(energy_rounding(hessian, far, points) ==
        doctest::Approx(size * (size + 101.0) * eps * norm_of_block));
  // Rotations are known to eps, wherever the body is.
  const DofLayout body = DofLayout::build(std::vector<bool>{}, {false});
  CHECK(force_rounding(hessian, x, body)[0] == doctest::Approx(2.0 * eps * norm_of_block));
}
