// Quadratic bending: agrees with the hinge model at small angles, is blind to stretching in the plane, damps
// the rate of angles.
#include <doctest/doctest.h>

#include <support/hinge.h>

using namespace stark;
using namespace stark::test;

namespace {

FilledSample flat(double k) { return hinge_element(0.0, 0.0, {{"bending_stiffness", k}}); }

FilledSample damped(double previous, double k, double d, double h) {
  return hinge_element(0.0, previous, {{"bending_stiffness", k}, {"bending_damping", d}, {"time_step", h}});
}

}  // namespace

TEST_CASE("small folds have the energy of the hinge model, with an error of second order in the angle") {
  const Potential quadratic = compiled(models::flat_bending()),
                  hinge = compiled(models::discrete_shell_bending());
  const auto error = [&](double theta) {
    const double other = energy(hinge, damped(0.0, 1.0, 0.0, 1.0), folded(theta));
    return std::fabs(energy(quadratic, flat(1.0), folded(theta)) / other - 1.0);
  };
  CHECK(error(0.01) < 1e-4);
  CHECK(error(0.2) / error(0.1) == doctest::Approx(4.0).epsilon(0.1));
  CHECK(energy(quadratic, flat(1.0), folded(0.01)) ==
        doctest::Approx(0.5 * hinge_factor() * 1e-4).epsilon(1e-4));
}

TEST_CASE("the Hessian of a flat hinge across its plane is that of the hinge model") {
  const Potential quadratic = compiled(models::flat_bending()),
                  hinge = compiled(models::discrete_shell_bending());
  const std::vector<double> A = hessian(quadratic, flat(2.0), folded(0)),
                            B = hessian(hinge, damped(0.0, 2.0, 0.0, 1.0), folded(0));
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      CHECK(A[(3 * i + 2) * 12 + 3 * j + 2] ==
            doctest::Approx(B[(3 * i + 2) * 12 + 3 * j + 2]).epsilon(1e-9));
}

TEST_CASE("affine motion does not bend") {
  const Potential potential = compiled(models::flat_bending());
  const Mat3 F{{1.3, 0.2, 5, -0.1, 0.8, 7, 0.4, 0.5, 9}};
  const std::vector<Vec3> x = mapped(F, folded(0));
  CHECK(energy(potential, flat(1.0), x) < 1e-25);
  CHECK(largest(gradient(potential, flat(1.0), x)) < 1e-13);
}

TEST_CASE("damping is that of the hinge model, with quadratic bending beside it") {
  const Potential both = compiled(models::damped_flat_bending()),
                  quadratic = compiled(models::flat_bending()),
                  hinge = compiled(models::discrete_shell_bending());
  const std::vector<Vec3> x = folded(1.3);
  const std::vector<double> all = gradient(both, damped(0.4, 2.0, 3.0, 0.01), x),
                            elastic = gradient(quadratic, flat(2.0), x),
                            viscous = gradient(hinge, damped(0.4, 0.0, 3.0, 0.01), x);
  for (size_t i = 0; i < all.size(); ++i)
    CHECK(std::fabs(all[i] - elastic[i] - viscous[i]) < 1e-12 * largest(all));
  CHECK(largest(viscous) > 0.1 * largest(all));
}

TEST_CASE("a fold that turns is not damped") {
  const Potential both = compiled(models::damped_flat_bending());
  const Mat3 turn{{0, 0, 1, 1, 0, 0, 0, 1, 0}};
  const FilledSample sample = damped(1.3, 0.0, 3.0, 0.01);
  CHECK(energy(both, sample, mapped(turn, folded(1.3))) < 1e-25);
  CHECK(energy(both, sample, folded(1.2)) > 0.1);
}
