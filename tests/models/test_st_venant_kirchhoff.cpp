// St. Venant-Kirchhoff: linear elasticity at small strain, cubic uniaxial stress, simple shear.
#include <support/law_checks.h>

using namespace stark;
using namespace stark::test;

namespace {

LawProbe probe(double E, double nu) {
  return {models::st_venant_kirchhoff(), {{"youngs_modulus", {E}}, {"poissons_ratio", {nu}}}};
}

}  // namespace

TEST_CASE("the Hessian at rest is that of linear elasticity") {
  for (const double nu : {0.0, 0.3, 0.49})
    check_small_strain(probe(2e4, nu), shear_modulus(2e4, nu), lame_lambda(2e4, nu));
}

TEST_CASE("a free bar has the stress E a (a^2 - 1)/2 at the stretch a") {
  const LawProbe law = probe(5.0, 0.35);
  for (const double a : {0.8, 0.95, 1.2, 1.6}) {
    CHECK(law.uniaxial_stress(a) == doctest::Approx(5.0 * a * (a * a - 1) / 2).epsilon(1e-9));
    CHECK(law.lateral_stretch(a) == doctest::Approx(std::sqrt(1 - 0.35 * (a * a - 1))).epsilon(1e-9));
  }
}

TEST_CASE("simple shear has the stress mu gamma + (lambda/2 + mu) gamma^3") {
  const double mu = shear_modulus(3e3, 0.3), lambda = lame_lambda(3e3, 0.3);
  const LawProbe law = probe(3e3, 0.3);
  for (const double g : {0.1, 0.5, 2.0}) {
    Mat3 F = Mat3::identity();
    F(0, 1) = g;
    CHECK(law.stress(F, unit_entry(0, 1)) ==
          doctest::Approx(mu * g + (lambda / 2 + mu) * g * g * g).epsilon(1e-10));
  }
}
