// Damping of solids: dissipated power eta |dE/dt|^2 per volume, whatever the time step; none in rigid motion.
#include <doctest/doctest.h>

#include <stark/base/rotation.h>
#include <support/model_checks.h>
#include <support/random_points.h>

using namespace stark;
using namespace stark::test;

TEST_CASE("the force of damping is that of the strain rate, independent of the time step") {
  const Potential potential = compiled(tet4(models::solid_damping()));
  const std::vector<Vec3> X{{0.1, 0, 0}, {1.2, 0.1, 0}, {0.4, 0.9, 0.1}, {0.5, 0.3, 0.8}};
  const double volume = dot(X[1] - X[0], cross(X[2] - X[0], X[3] - X[0])) / 6.0, eta = 7.0;
  RandomPoints random(1);
  for (int trial = 0; trial < 10; ++trial) {
    const Mat3 F =
        Mat3::identity() + Mat3::from_columns(random.point(), random.point(), random.point()) * 0.3;
    const Mat3 rate = Mat3::from_columns(random.point(), random.point(), random.point());
    const Mat3 strain_rate = (transpose(F) * rate + transpose(rate) * F) * 0.5;
    const std::vector<Vec3> velocity = mapped(rate, X);
    for (const double h : {1e-6, 5e-6}) {  // first order in h: strain changes by 1e-5 at most
      const FilledSample sample = element(X, mapped(F, X), {{"strain_damping", eta}, {"time_step", h}});
      const std::vector<double> g = gradient(potential, sample, mapped(F + rate * h, X));
      CHECK(work(g, velocity) ==
            doctest::Approx(eta * volume * squared_frobenius(strain_rate)).epsilon(1e-4));
    }
  }
}

TEST_CASE("rigid motion is not damped") {
  const Potential potential = compiled(tet4(models::solid_damping()));
  const std::vector<Vec3> X{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const FilledSample sample =
      element(X, mapped(Mat3::diagonal({1.2, 0.9, 1.0}), X), {{"strain_damping", 7.0}, {"time_step", 0.01}});
  std::vector<Vec3> x = mapped(exp_rotation({1, 2, 3}) * Mat3::diagonal({1.2, 0.9, 1.0}), X);
  for (Vec3& p : x) p += {5, 6, 7};
  CHECK(energy(potential, sample, x) < 1e-25);
  CHECK(largest(gradient(potential, sample, x)) < 1e-11);
}
