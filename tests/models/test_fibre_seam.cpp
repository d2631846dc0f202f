// The seam of a fibre: k (1 - cos) of the turn against the body, nothing for rigid motion and for motion of
// the neighbour along the fibre.
#include <doctest/doctest.h>

#include <cmath>

#include <stark/base/rotation.h>
#include <stark/sim/scene/registry.h>
#include <support/model_checks.h>

using namespace stark;
using namespace stark::test;

namespace {

const std::vector<Vec3> kRest{{0, 0, 0}, {0.3, 0.1, 0.2}, {1, 0, 0}, {0, 1, 0}};

double energy_at(const std::vector<Vec3>& x) {
  const Potential potential = compiled(models::fibre_seam());
  return test::energy(potential, element(kRest, kRest, {{"stiffness", 2.0}}), x);
}

std::vector<Vec3> turned(double angle) {
  const Mat3 R = exp_rotation({0, 0, angle});
  return {kRest[0], kRest[1], R * kRest[2], R * kRest[3]};
}

}  // namespace

TEST_CASE("the energy is that of the angle between section and body") {
  for (const double angle : {1e-6, 0.5, -2.0, 3.0})
    CHECK(energy_at(turned(angle)) == doctest::Approx(2.0 * (1.0 - std::cos(angle))).epsilon(1e-4));
  CHECK(energy_at(turned(1e-6)) == doctest::Approx(1e-12).epsilon(1e-6));
}

TEST_CASE("rigid motion and motion along the fibre cost nothing") {
  const Mat3 Q = exp_rotation({1.0, -2.0, 0.7});
  std::vector<Vec3> moved;
  for (size_t i = 0; i < 4; ++i) moved.push_back(Q * kRest[i] + (i < 2 ? Vec3{3, -1, 2} : Vec3{}));
  CHECK(energy_at(moved) < 1e-28);
  std::vector<Vec3> slid = kRest;
  slid[1] = {0.6, 0.2, -0.5};
  CHECK(energy_at(slid) < 1e-28);
}

TEST_CASE("a neighbour that comes into the line of the fibre tells less and less, and then nothing") {
  const double rest = std::hypot(0.3, 0.1);
  const auto at = [&](double share, double angle) {
    std::vector<Vec3> x = kRest;
    const Vec3 across = exp_rotation({0, 0, angle}) * Vec3{0.3, 0.1, 0.0};
    x[1] = across * share + Vec3{0, 0, 0.2};
    return energy_at(x);
  };
  CHECK(at(0.21, 1.0) == doctest::Approx(2.0 * (1.0 - std::cos(1.0))));
  CHECK(at(0.0, 1.0) == doctest::Approx(1.0));
  CHECK(at(1e-9 / rest, 1.0) == doctest::Approx(at(1e-9 / rest, 2.0)).epsilon(1e-7));
  for (const double share : {0.15, 0.1, 0.05}) CHECK(at(share, 1.0) < 1.0);
}
