// St. Venant-Kirchhoff membrane in plane stress: Hooke's law of the Green strain E = (F^T F - 1)/2 of the
// 3x2 deformation gradient. psi = mu E : E + lambda/2 (tr E)^2 with lambda = E nu/(1 - nu^2).
#include <stark/models/elastic_constants.h>

namespace stark::models {

ShellLaw membrane_st_venant_kirchhoff() {
  ShellLaw law = define_shell_law("membrane_st_venant_kirchhoff", "St. Venant-Kirchhoff membrane elasticity",
                                  [](PotentialBuilder& b, const ShellDeformation& deformation) {
                                    const auto [mu, lambda] = plane_stress_constants(b);
                                    const Mat32 F = deformation.F();
                                    const Mat2 E = 0.5 * (transpose(F) * F - Mat2::identity());
                                    return mu * squared_norm(E) + 0.5 * lambda * square(trace(E));
                                  });
  law.sample = sample_poissons_ratio;
  return law;
}

}  // namespace stark::models
