// St. Venant-Kirchhoff elasticity: Hooke's law of the Green strain E = (F^T F - 1)/2.
// psi = mu E : E + lambda/2 (tr E)^2. Finite everywhere; it softens under compression (the nominal stress of
// a uniaxial test falls again below a stretch of 0.58), so strong compression calls for another law.
#include <stark/models/elastic_constants.h>

namespace stark::models {

SolidLaw st_venant_kirchhoff() {
  SolidLaw law = define_solid_law("st_venant_kirchhoff", "St. Venant-Kirchhoff elasticity",
                                  [](PotentialBuilder& b, const SolidDeformation& deformation) {
                                    const auto [mu, lambda] = lame_constants(b);
                                    const Mat3 F = deformation.F();
                                    const Mat3 E = 0.5 * (transpose(F) * F - Mat3::identity());
                                    return mu * squared_norm(E) + 0.5 * lambda * square(trace(E));
                                  });
  law.sample = sample_poissons_ratio;
  return law;
}

}  // namespace stark::models
