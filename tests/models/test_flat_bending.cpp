// Quadratic bending: agrees with the hinge model at small angles, is blind to stretching in the plane, damps
// the rate.
#include <doctest/doctest.h>

#include <support/hinge.h>

using namespace stark;
using namespace stark::test;

namespace {

FilledSample flat(double previous, double k, double d, double h) {
  return hinge_element(0.0, previous, {{"bending_stiffness", k}, {"bending_damping", d}, {"time_step", h}});
}

}  // namespace

TEST_CASE("small folds have the energy of the hinge model, with an error of second order in the angle") {
  const Potential quadratic = compiled(models::flat_bending()),
                  hinge = compiled(models::discrete_shell_bending());
  const auto error = [&](double theta) {
    const FilledSample sample = flat(0.0, 1.0, 0.0, 1.0);
    return std::fabs(energy(quadratic, sample, folded(theta)) / energy(hinge, sample, folded(theta)) - 1.0);
  };
  CHECK(error(0.01) < 1e-4);
  CHECK(error(0.2) / error(0.1) == doctest::Approx(4.0).epsilon(0.1));
  CHECK(energy(quadratic, flat(0, 1, 0, 1), folded(0.01)) ==
        doctest::Approx(0.5 * hinge_factor() * 1e-4).epsilon(1e-4));
}

TEST_CASE("the Hessian of a flat hinge across its plane is that of the hinge model") {
  const Potential quadratic = compiled(models::flat_bending()),
                  hinge = compiled(models::discrete_shell_bending());
  const FilledSample sample = flat(0.0, 2.0, 0.0, 1.0);
  const std::vector<double> A = hessian(quadratic, sample, folded(0)), B = hessian(hinge, sample, folded(0));
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      CHECK(A[(3 * i + 2) * 12 + 3 * j + 2] ==
            doctest::Approx(B[(3 * i + 2) * 12 + 3 * j + 2]).epsilon(1e-9));
}

TEST_CASE("affine motion does not bend") {
  const Potential potential = compiled(models::flat_bending());
  const Mat3 F{{1.3, 0.2, 5, -0.1, 0.8, 7, 0.4, 0.5, 9}};
  const std::vector<Vec3> x = mapped(F, folded(0));
  CHECK(energy(potential, flat(0.0, 1.0, 0.0, 1.0), x) < 1e-25);
  CHECK(largest(gradient(potential, flat(0.0, 1.0, 0.0, 1.0), x)) < 1e-13);
}

TEST_CASE("damping is proportional to the motion within the step over its length") {
  const Potential potential = compiled(models::flat_bending());
  const std::vector<Vec3> velocity{{0.1, 0, 0.5}, {0, 0, -0.2}, {0, 0.3, 1}, {0, 0, 2}};
  const auto force = [&](double h) {
    std::vector<Vec3> x = folded(0.4);
    for (size_t i = 0; i < x.size(); ++i) x[i] += velocity[i] * h;
    return gradient(potential, flat(0.4, 0.0, 3.0, h), x);
  };
  const std::vector<double> a = force(0.1), b = force(0.001);
  for (size_t i = 0; i < a.size(); ++i) CHECK(std::fabs(a[i] - b[i]) < 1e-10 * largest(a));
  CHECK(largest(a) > 0.1);
  CHECK(work(a, velocity) > 0.0);
}
