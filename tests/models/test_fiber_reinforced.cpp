// Fibres: exponential in tension, absent in compression and across, whatever the length of the direction.
#include <support/law_checks.h>

using namespace stark;
using namespace stark::test;

namespace {

const double kStiffness = 5e3, kExponent = 2.0;

LawProbe probe(const Vec3& a) {
  return {models::fiber_reinforced(),
          {{"youngs_modulus", {1e4}},
           {"poissons_ratio", {0.3}},
           {"fiber_stiffness", {kStiffness}},
           {"fiber_exponent", {kExponent}},
           {"fiber_direction", {a.x, a.y, a.z}}}};
}

LawProbe matrix() {
  return {models::stable_neo_hookean(), {{"youngs_modulus", {1e4}}, {"poissons_ratio", {0.3}}}};
}

}  // namespace

TEST_CASE("the fibres add k1/(2 k2) (exp(k2 (I4 - 1)^2) - 1) in tension and nothing else") {
  const Vec3 a{1.0, 2.0, -0.5};
  const Vec3 unit = a * (1.0 / norm(a));
  const LawProbe law = probe(a), plain = matrix();
  RandomPoints random(3);
  for (int trial = 0; trial < 20; ++trial) {
    const Mat3 F =
        Mat3::identity() + Mat3::from_columns(random.point(), random.point(), random.point()) * 0.3;
    const double excess = std::fmax(dot(F * unit, F * unit) - 1.0, 0.0);
    const double fibers = kStiffness / (2 * kExponent) * std::expm1(kExponent * excess * excess);
    CHECK(law.density(F) - plain.density(F) == doctest::Approx(fibers).epsilon(1e-9).scale(1e4));
  }
}

TEST_CASE("small extension along the fibres meets 4 k1 more than the matrix gives") {
  const double e = 1e-5;
  const LawProbe law = probe({1, 0, 0}), plain = matrix();
  const Mat3 longer = Mat3::diagonal({1 + e, 1, 1}), shorter = Mat3::diagonal({1 - e, 1, 1});
  const Mat3 along = unit_entry(0, 0);
  CHECK((law.stress(longer, along) - plain.stress(longer, along)) / e ==
        doctest::Approx(4 * kStiffness).epsilon(1e-4));
  CHECK(law.stress(shorter, along) == doctest::Approx(plain.stress(shorter, along)).epsilon(1e-12));
}
