// Hinges with rest angles: energy of a folded pair of triangles, sign of the rest angle, damping of the fold
// rate.
#include <doctest/doctest.h>

#include <support/hinge.h>

using namespace stark;
using namespace stark::test;

TEST_CASE("energy is k/2 3 |e|^2 / (A_a + A_b) (theta - theta_0)^2") {
  const Potential potential = compiled(models::discrete_shell_bending());
  const double k = 0.02;
  for (const double rest : {-1.0, 0.0, 0.5})
    for (const double theta : {-2.5, -0.3, 0.0, 1e-3, 0.5, 3.0}) {
      const FilledSample sample = hinge_element(
          rest, theta, {{"bending_stiffness", k}, {"bending_damping", 0.0}, {"time_step", 0.1}});
      CHECK(energy(potential, sample, folded(theta)) ==
            doctest::Approx(0.5 * k * hinge_factor() * (theta - rest) * (theta - rest))
                .epsilon(1e-9)
                .scale(1e-6));
    }
}

TEST_CASE("the moment drives the fold towards the rest angle") {
  const Potential potential = compiled(models::discrete_shell_bending());
  const FilledSample sample =
      hinge_element(0.5, 0.0, {{"bending_stiffness", 1.0}, {"bending_damping", 0.0}, {"time_step", 0.1}});
  const auto slope = [&](double theta) {  // dE/dtheta by the motion of the folding wing
    const double e = 1e-6;
    const std::vector<Vec3> a = folded(theta - e), b = folded(theta + e);
    std::vector<Vec3> rate;
    for (size_t i = 0; i < a.size(); ++i) rate.push_back((b[i] - a[i]) / (2 * e));
    return work(gradient(potential, sample, folded(theta)), rate);
  };
  CHECK(slope(0.7) == doctest::Approx(hinge_factor() * 0.2).epsilon(1e-6));
  CHECK(slope(0.1) == doctest::Approx(hinge_factor() * -0.4).epsilon(1e-6));
}

TEST_CASE("damping dissipates d (dtheta/dt)^2, independent of the time step") {
  const Potential potential = compiled(models::discrete_shell_bending());
  const double d = 0.3, theta = 0.8, rate = 2.0;
  for (const double h : {1e-5, 1e-4, 1e-3}) {
    const FilledSample sample =
        hinge_element(0.0, theta, {{"bending_stiffness", 0.0}, {"bending_damping", d}, {"time_step", h}});
    const std::vector<Vec3> x = folded(theta + rate * h);
    CHECK(energy(potential, sample, x) ==
          doctest::Approx(0.5 * d * hinge_factor() * rate * rate * h).epsilon(1e-8));
  }
}
