// Damping of membranes: dissipated power d |dE/dt|^2 per area, whatever the time step; none in rigid motion.
#include <doctest/doctest.h>

#include <support/model_checks.h>

using namespace stark;
using namespace stark::test;

TEST_CASE("the force of damping is that of the strain rate, independent of the time step") {
  const Potential potential = compiled(models::membrane_damping());
  const std::vector<Vec3> X{{0.1, 0, 0}, {1.2, 0.1, 0}, {0.4, 0.9, 0}};
  const double area = 0.5 * norm(cross(X[1] - X[0], X[2] - X[0])), d = 3.0;
  const Mat3 F{{1.2, 0.1, 0, -0.2, 0.9, 0, 0, 0, 1}}, R = exp_rotation({1, 2, 3});
  const Mat3 rate{{0.3, -0.7, 0, 0.2, 0.5, 0, 0, 0, 0}};
  const Mat3 strain_rate = (transpose(F) * rate + transpose(rate) * F) * 0.5;
  for (const double h : {1e-6, 5e-6}) {
    const FilledSample sample = element(X, mapped(F, X), {{"strain_damping", d}, {"time_step", h}});
    const std::vector<double> g = gradient(potential, sample, mapped(F + rate * h, X));
    CHECK(work(g, mapped(rate, X)) ==
          doctest::Approx(d * area * squared_frobenius(strain_rate)).epsilon(1e-4));
    std::vector<Vec3> turned = mapped(R * F, X);
    CHECK(energy(potential, sample, turned) < 1e-20);  // (1e-16)^2 / h
  }
}
