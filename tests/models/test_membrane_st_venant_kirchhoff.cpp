// St. Venant-Kirchhoff membrane: plane stress at small strain, cubic stress at large ones, any orientation.
#include <support/law_checks.h>

#include <stark/base/rotation.h>

using namespace stark;
using namespace stark::test;

namespace {

LawProbe probe(double E, double nu, double thickness) {
  return {models::membrane_st_venant_kirchhoff(),
          {{"youngs_modulus", {E}}, {"poissons_ratio", {nu}}, {"thickness", {thickness}}}};
}

}  // namespace

TEST_CASE("energy is that of Hooke's law of plane stress in the Green strain") {
  const double E = 5e3, nu = 0.3, t = 2e-3, mu = shear_modulus(E, nu), lambda = E * nu / (1 - nu * nu);
  const LawProbe law = probe(E, nu, t);
  RandomPoints random(2);
  for (int trial = 0; trial < 10; ++trial) {
    Mat3 F = Mat3::identity() + Mat3::from_columns(random.point(), random.point(), {}) * 0.4;
    const Mat3 C = transpose(F) * F;
    const double e11 = 0.5 * (C(0, 0) - 1), e22 = 0.5 * (C(1, 1) - 1), e12 = 0.5 * C(0, 1);
    const double psi = mu * (e11 * e11 + e22 * e22 + 2 * e12 * e12) + lambda / 2 * (e11 + e22) * (e11 + e22);
    CHECK(law.density(F) == doctest::Approx(psi * t).epsilon(1e-10));
    CHECK(law.density(exp_rotation(random.point()) * F) == doctest::Approx(psi * t).epsilon(1e-10));
  }
}

TEST_CASE("uniaxial plane stress: stiffness E t, contraction nu") {
  const double E = 5e3, nu = 0.4, t = 2e-3, e = 1e-6;
  const LawProbe law = probe(E, nu, t);
  const Mat3 F = Mat3::diagonal({1 + e, 1 - nu * e, 1});
  CHECK(law.stress(F, unit_entry(0, 0)) == doctest::Approx(E * t * e).epsilon(1e-5));
  CHECK(std::fabs(law.stress(F, unit_entry(1, 1))) < 1e-5 * E * t * e);
}
