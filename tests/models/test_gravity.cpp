// Weight: force m g, energy -m g . x.
#include <doctest/doctest.h>

#include <support/model_checks.h>

using namespace stark;
using namespace stark::test;

TEST_CASE("weight is m g everywhere") {
  const Potential potential = compiled(models::gravity());
  FilledSample sample = element({{}}, {{}}, {{"mass", 3.0}});
  sample.values["gravity"] = {0.5, -1.0, -9.81};
  for (const Vec3& x : {Vec3{}, Vec3{1, 2, 3}, Vec3{-100, 50, 7}}) {
    CHECK(energy(potential, sample, {x}) ==
          doctest::Approx(-3.0 * (0.5 * x.x - x.y - 9.81 * x.z)).epsilon(1e-14));
    const std::vector<double> g = gradient(potential, sample, {x});
    CHECK(g[0] == doctest::Approx(-1.5));
    CHECK(g[1] == doctest::Approx(3.0));
    CHECK(g[2] == doctest::Approx(29.43));
    CHECK(largest(hessian(potential, sample, {x})) == 0.0);
  }
}
