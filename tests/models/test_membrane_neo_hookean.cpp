// Membranes: plane stress at small strain, closed-form energy at large ones, resistance to collapse.
#include <doctest/doctest.h>

#include <support/model_checks.h>

using namespace stark;
using namespace stark::test;

namespace {

const std::vector<Vec3> kTriangle{{0.1, 0, 0}, {1.2, 0.1, 0}, {0.4, 0.9, 0}};
double area() { return 0.5 * norm(cross(kTriangle[1] - kTriangle[0], kTriangle[2] - kTriangle[0])); }

FilledSample triangle(double E, double nu, double thickness) {
  return element(kTriangle, kTriangle,
                 {{"youngs_modulus", E}, {"poissons_ratio", nu}, {"thickness", thickness}});
}

}  // namespace

TEST_CASE("uniaxial plane stress: stiffness E t, lateral contraction nu") {
  const Potential potential = compiled(models::membrane_neo_hookean());
  const double E = 5e3, thickness = 2e-3;
  for (const double nu : {0.0, 0.3, 0.49}) {
    const std::vector<double> K = hessian(potential, triangle(E, nu, thickness), kTriangle);
    const std::vector<Vec3> along = mapped(Mat3::diagonal({1, 0, 0}), kTriangle),
                            across = mapped(Mat3::diagonal({0, 1, 0}), kTriangle);
    const double aa = form(K, along, along), ab = form(K, along, across), bb = form(K, across, across);
    CHECK(aa - ab * ab / bb == doctest::Approx(E * thickness * area()).epsilon(1e-9));
    CHECK(ab / bb == doctest::Approx(nu).epsilon(1e-9));
    Mat3 shear;
    shear(0, 1) = 1.0;
    const std::vector<Vec3> sheared = mapped(shear, kTriangle);
    CHECK(form(K, sheared, sheared) ==
          doctest::Approx(E / (2 * (1 + nu)) * thickness * area()).epsilon(1e-9));
    // No stiffness out of the plane at rest.
    const std::vector<Vec3> out{{0, 0, 1}, {0, 0, -2}, {0, 0, 0.5}};
    CHECK(std::fabs(form(K, out, out)) < 1e-9 * aa);
  }
}

TEST_CASE("large stretches have the energy of the principal stretches, in any plane") {
  const Potential potential = compiled(models::membrane_neo_hookean());
  const double E = 5e3, nu = 0.3, thickness = 2e-3, mu = E / (2 * (1 + nu)), lambda = E * nu / (1 - nu * nu);
  const Mat3 R = exp_rotation({0.3, -1.0, 2.0});
  for (const double a : {0.5, 0.9, 1.5})
    for (const double b : {0.7, 1.0, 2.0}) {
      const double log_J = std::log(a * b);
      const double psi = 0.5 * mu * (a * a + b * b - 2) - mu * log_J + 0.5 * lambda * log_J * log_J;
      const std::vector<Vec3> x = mapped(R * Mat3::diagonal({a, b, 1}), kTriangle);
      CHECK(energy(potential, triangle(E, nu, thickness), x) ==
            doctest::Approx(psi * thickness * area()).epsilon(1e-10).scale(E * thickness * 1e-3));
    }
}

TEST_CASE("energy grows without bound as a triangle collapses") {
  const Potential potential = compiled(models::membrane_neo_hookean());
  double last = 0.0;
  for (const double b : {1e-1, 1e-3, 1e-6, 1e-7}) {
    const double now =
        energy(potential, triangle(1.0, 0.3, 1.0), mapped(Mat3::diagonal({1, b, 1}), kTriangle));
    CHECK(now > last);
    last = now;
  }
  CHECK(last > 20.0 * area());
}
