// Compressible Neo-Hookean elasticity with logarithmic volume terms.
// psi = mu/2 (tr C - 3) - mu ln J + lambda/2 (ln J)^2 [Simo and Pister 1984; Bonet and Wood 2008, eq. 6.28].
// Not defined at J <= 0: such a trial is refused by the line search.
#include <stark/models/elastic_constants.h>

namespace stark::models {

SolidLaw neo_hookean() {
  SolidLaw law = define_solid_law("neo_hookean", "compressible Neo-Hookean elasticity (ln J)",
                                  [](PotentialBuilder& b, const SolidDeformation& deformation) {
                                    const auto [mu, lambda] = lame_constants(b);
                                    const Mat3 F = deformation.F();
                                    const Scalar log_J = log(determinant(F));
                                    return 0.5 * mu * (squared_norm(F) - 3.0) - mu * log_J +
                                           0.5 * lambda * square(log_J);
                                  });
  law.sample = sample_poissons_ratio;
  return law;
}

}  // namespace stark::models
