// Logarithmic Neo-Hookean law: linear elasticity at small strain, tables of uniaxial stress, simple shear.
#include <support/law_checks.h>

using namespace stark;
using namespace stark::test;

namespace {

LawProbe probe(double E, double nu) {
  return {models::neo_hookean(), {{"youngs_modulus", {E}}, {"poissons_ratio", {nu}}}};
}

}  // namespace

TEST_CASE("the Hessian at rest is that of linear elasticity") {
  for (const double nu : {0.0, 0.3, 0.49})
    check_small_strain(probe(2e4, nu), shear_modulus(2e4, nu), lame_lambda(2e4, nu));
}

TEST_CASE("uniaxial stress has the values of an independent solution") {
  // P/E of mu (a - 1/a) + lambda ln(a b^2)/a with the lateral stretch solved by Brent's method in Python.
  const std::pair<double, double> table[] = {
      {0.7, -0.40523}, {0.9, -0.10872}, {1.1, 0.09308}, {1.5, 0.37828}};
  const LawProbe law = probe(1.0, 0.3);
  for (const auto& [stretch, stress] : table)
    CHECK(std::fabs(law.uniaxial_stress(stretch) - stress) < 6e-6);  // five printed digits
}

TEST_CASE("simple shear has the shear stress mu gamma") {
  const double E = 3e3, nu = 0.4;
  const LawProbe law = probe(E, nu);
  for (const double gamma : {0.1, 0.5, 2.0}) {
    Mat3 F = Mat3::identity();
    F(0, 1) = gamma;
    CHECK(law.stress(F, unit_entry(0, 1)) == doctest::Approx(shear_modulus(E, nu) * gamma).epsilon(1e-10));
  }
}

TEST_CASE("the energy grows without bound towards zero volume and is refused beyond") {
  const LawProbe law = probe(1.0, 0.3);
  CHECK(law.density(Mat3::diagonal({1, 1, 1e-6})) > law.density(Mat3::diagonal({1, 1, 1e-3})));
  CHECK(law.density(Mat3::diagonal({1, 1, 1e-3})) > 5.0);
  CHECK_FALSE(std::isfinite(law.density(Mat3::diagonal({1, 1, -0.1}))));
}
