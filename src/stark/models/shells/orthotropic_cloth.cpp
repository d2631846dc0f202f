// Woven cloth: orthotropic Hooke's law in plane stress of the Green strain E in warp and weft directions.
// psi = (E1 E11^2 + 2 nu sqrt(E1 E2) E11 E22 + E2 E22^2) / (2 (1 - nu^2)) + 2 G E12^2 with the geometric mean
// nu of the two Poisson's ratios, which are tied by nu_12 E2 = nu_21 E1: tension along the warp contracts the
// weft by nu sqrt(E1/E2), and every nu below 1 is stable. [Jones 1999, "Mechanics of Composite Materials",
// sec. 2.5]
#include <stark/mechanics/define.h>

namespace stark::models {

ShellLaw orthotropic_cloth() {
  ShellLaw law = define_shell_law(
      "orthotropic_cloth", "orthotropic membrane elasticity of woven cloth",
      [](PotentialBuilder& b, const ShellDeformation& deformation) {
        const Scalar E1 = b.parameter("warp_modulus", "Pa", "Young's modulus along the warp", positive());
        const Scalar E2 = b.parameter("weft_modulus", "Pa", "Young's modulus along the weft", positive());
        const Scalar G = b.parameter("shear_modulus", "Pa", "shear modulus of the weave", positive());
        const Scalar nu = b.parameter("poissons_ratio", "1", "geometric mean of the two Poisson's ratios",
                                      half_open_interval(0.0, 0.5));
        const Mat32 F = deformation.F();
        const Mat2 E = 0.5 * (transpose(F) * F - Mat2::identity());
        const Scalar stretch =
            E1 * square(E(0, 0)) + 2.0 * nu * sqrt(E1 * E2) * E(0, 0) * E(1, 1) + E2 * square(E(1, 1));
        return stretch / (2.0 * (1.0 - nu * nu)) + 2.0 * G * square(E(0, 1));
      });
  law.isotropic = false;
  law.sample = [](std::mt19937_64& random) {
    return std::map<std::string, std::vector<double>>{
        {"poissons_ratio", {std::uniform_real_distribution<double>(0.0, 0.45)(random)}},
        {"warp_direction", {1.0, 0.3, 0.2}}};
  };
  return law;
}

}  // namespace stark::models
