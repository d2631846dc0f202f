// Stable Neo-Hookean elasticity.
// [Smith, de Goes, Kim 2018, "Stable Neo-Hookean Flesh Simulation", eq. 14, with the Lame reparametrisation
// of sec. 3.4 for the log term, so that small strains agree with linear elasticity.] The energy of the rest
// state is subtracted. Finite for flat and inverted elements. [theory eq. 10]
#include <stark/models/elastic_constants.h>

namespace stark::models {

SolidLaw stable_neo_hookean() {
  SolidLaw law = define_solid_law(
      "stable_neo_hookean", "stable Neo-Hookean elasticity",
      [](PotentialBuilder& b, const SolidDeformation& deformation) {
        const auto [mu_small, lambda_small] = lame_constants(b);
        const Scalar mu = 4.0 / 3.0 * mu_small;
        const Scalar lambda = lambda_small + 5.0 / 6.0 * mu_small;
        const Scalar alpha = 1.0 + 0.75 * mu / lambda;

        const Mat3 F = deformation.F();
        const Scalar I_C = squared_norm(F), J = determinant(F);
        const Scalar rest = 0.5 * lambda * square(1.0 - alpha) - 0.5 * mu * std::log(4.0);
        return 0.5 * mu * (I_C - 3.0) + 0.5 * lambda * square(J - alpha) - 0.5 * mu * log(I_C + 1.0) - rest;
      });
  law.sample = sample_poissons_ratio;
  return law;
}

}  // namespace stark::models
