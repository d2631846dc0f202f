// Woven cloth: two moduli, two Poisson's ratios, shear, whatever the direction of the warp in the mesh.
#include <support/law_checks.h>

#include <stark/base/rotation.h>

using namespace stark;
using namespace stark::test;

namespace {

const double kWarp = 8e3, kWeft = 2e3, kShear = 500.0, kNu = 0.2, kThickness = 1e-3;

LawProbe probe(const Vec3& warp) {
  return {models::orthotropic_cloth(),
          {{"warp_modulus", {kWarp}},
           {"weft_modulus", {kWeft}},
           {"shear_modulus", {kShear}},
           {"poissons_ratio", {kNu}},
           {"thickness", {kThickness}},
           {"warp_direction", {warp.x, warp.y, warp.z}}}};
}

}  // namespace

TEST_CASE("tension along warp and weft: their moduli and Poisson's ratios") {
  const double e = 1e-6;
  for (const double angle : {0.0, 0.4, 1.3}) {
    const Mat3 Q = exp_rotation({0, 0, angle});
    const LawProbe law = probe(Q * Vec3{2, 0, 0.7});  // only the part in the plane counts
    const auto stress = [&](const Vec3& stretch, int axis) {
      return law.stress(Q * Mat3::diagonal(stretch) * transpose(Q),
                        Q * unit_entry(axis, axis) * transpose(Q));
    };
    const double along_warp = kNu * std::sqrt(kWarp / kWeft), along_weft = kNu * std::sqrt(kWeft / kWarp);
    const Vec3 warp{1 + e, 1 - along_warp * e, 1}, weft{1 - along_weft * e, 1 + e, 1};
    CHECK(stress(warp, 0) == doctest::Approx(kWarp * kThickness * e).epsilon(1e-5));
    CHECK(std::fabs(stress(warp, 1)) < 1e-5 * kWarp * kThickness * e);
    CHECK(stress(weft, 1) == doctest::Approx(kWeft * kThickness * e).epsilon(1e-5));
    CHECK(std::fabs(stress(weft, 0)) < 1e-5 * kWarp * kThickness * e);
    const Mat3 shear = Q * unit_entry(0, 1) * transpose(Q);
    CHECK(law.stress(Mat3::identity() + shear * e, shear) ==
          doctest::Approx(kShear * kThickness * e).epsilon(1e-5));
  }
}

TEST_CASE("with equal moduli and G = E/(2 (1 + nu)) the weave is isotropic") {
  const double E = 3e3;
  std::map<std::string, std::vector<double>> values{
      {"warp_modulus", {E}},       {"weft_modulus", {E}},
      {"poissons_ratio", {kNu}},   {"shear_modulus", {shear_modulus(E, kNu)}},
      {"thickness", {kThickness}}, {"warp_direction", {1, 0.4, 0}}};
  const LawProbe weave(models::orthotropic_cloth(), values);
  const LawProbe isotropic(models::membrane_st_venant_kirchhoff(),
                           {{"youngs_modulus", {E}}, {"poissons_ratio", {kNu}}, {"thickness", {kThickness}}});
  RandomPoints random(2);
  for (int trial = 0; trial < 10; ++trial) {
    const Mat3 F = Mat3::identity() + Mat3::from_columns(random.point(), random.point(), {}) * 0.4;
    CHECK(weave.density(F) == doctest::Approx(isotropic.density(F)).epsilon(1e-10));
  }
}
