// Mooney-Rivlin: linear elasticity at small strain, the incompressible limit of Mooney's formula.
#include <support/law_checks.h>

using namespace stark;
using namespace stark::test;

namespace {

LawProbe probe(double c10, double c01, double bulk) {
  return {models::mooney_rivlin(), {{"c10", {c10}}, {"c01", {c01}}, {"bulk_modulus", {bulk}}}};
}

}  // namespace

TEST_CASE("small strains: shear modulus 2 (c10 + c01), bulk modulus K, no stress at rest") {
  const double c10 = 3e3, c01 = 1e3, bulk = 4e4, mu = 2 * (c10 + c01);
  const LawProbe law = probe(c10, c01, bulk);
  check_small_strain(law, mu, bulk - 2.0 / 3.0 * mu);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      CHECK(std::fabs(law.stress(Mat3::identity(), unit_entry(i, j))) < 1e-11 * bulk);
}

TEST_CASE("a nearly incompressible bar has Mooney's stress 2 (a - a^-2) (c10 + c01/a)") {
  const double c10 = 3.0, c01 = 1.0, bulk = 1e7;
  const LawProbe law = probe(c10, c01, bulk);
  for (const double a : {0.6, 0.9, 1.3, 2.0})  // deviations of order c10/K
    CHECK(law.uniaxial_stress(a) == doctest::Approx(2 * (a - 1 / (a * a)) * (c10 + c01 / a)).epsilon(1e-5));
}

TEST_CASE("a change of volume alone meets K/2 (J - 1)^2 only") {
  const LawProbe law = probe(3.0, 1.0, 50.0);
  for (const double a : {0.8, 1.0, 1.4})
    CHECK(law.density(Mat3::identity() * a) ==
          doctest::Approx(25.0 * std::pow(a * a * a - 1, 2)).epsilon(1e-10));
}
