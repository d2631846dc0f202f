// Fixed corotated law: linear elasticity at small strain, energy and stress in principal stretches, inverted
// elements.
#include <support/law_checks.h>

#include <stark/base/rotation.h>

using namespace stark;
using namespace stark::test;

namespace {

const double kE = 2e4, kNu = 0.3, kMu = shear_modulus(kE, kNu), kLambda = lame_lambda(kE, kNu);

LawProbe probe() { return {models::corotated(), {{"youngs_modulus", {kE}}, {"poissons_ratio", {kNu}}}}; }

double principal_density(const Vec3& s) {
  const double J = s.x * s.y * s.z;
  const Vec3 e = s - Vec3{1, 1, 1};
  return kMu * dot(e, e) + 0.5 * kLambda * (J - 1) * (J - 1);
}

const std::vector<Vec3> kStretches{{1, 1, 1},       {1.3, 1, 1},      {1.2, 1.2, 0.7}, {0.5, 0.5, 0.5},
                                   {2, 2, 2},       {3, 0.4, 0.2},    {1, 0.5, 0.0},   {1.2, 0.9, -0.3},
                                   {1, 0.9, -0.85}, {0.11, 0.1, 0.1}, {4, 4, 0.1},     {1.5, 1e-3, 1e-3}};

}  // namespace

TEST_CASE("the Hessian at rest is that of linear elasticity") { check_small_strain(probe(), kMu, kLambda); }

TEST_CASE("energy is that of the principal stretches, equal and inverted ones included") {
  const LawProbe law = probe();
  RandomPoints random(4);
  for (const Vec3& s : kStretches) {
    const Mat3 R = exp_rotation(random.point() * 2.0), Q = exp_rotation(random.point() * 2.0);
    const double expected = principal_density(s);
    CHECK(std::fabs(law.density(R * Mat3::diagonal(s) * transpose(Q)) - expected) < 1e-9 * (kMu + expected));
  }
}

TEST_CASE("stress is 2 mu (F - R) + lambda (J - 1) cof F") {
  const LawProbe law = probe();
  RandomPoints random(5);
  for (const Vec3& s : kStretches) {
    const Mat3 R = exp_rotation(random.point() * 2.0), Q = exp_rotation(random.point() * 2.0);
    const Mat3 F = R * Mat3::diagonal(s) * transpose(Q), polar = R * transpose(Q);
    const Mat3 cofactor = Mat3::from_columns(cross(F.column(1), F.column(2)), cross(F.column(2), F.column(0)),
                                             cross(F.column(0), F.column(1)));
    const Mat3 P = (F - polar) * (2 * kMu) + cofactor * (kLambda * (determinant(F) - 1));
    const Mat3 rate = Mat3::from_columns(random.point(), random.point(), random.point());
    double expected = 0.0;
    for (int k = 0; k < 9; ++k) expected += P.m[k] * rate.m[k];
    // R moves by 1/(sigma_2 + sigma_3) times an error of F, which is the condition of the quartic's root.
    CHECK(std::fabs(law.stress(F, rate) - expected) <
          1e-12 * kE / std::fmin(1.0, s.y + s.z) * std::fmax(1.0, squared_frobenius(F)) * 10);
  }
}
