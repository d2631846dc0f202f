// Stable Neo-Hookean elasticity of linear tetrahedra.
// [Smith, de Goes, Kim 2018, "Stable Neo-Hookean Flesh Simulation", eq. 14, with the Lame reparametrisation
// of sec. 3.4 for the log term, so that small strains agree with linear elasticity.] The energy of the rest
// state is subtracted.
#include <stark/models/solids/deformation.h>

namespace stark::models {

PotentialDefinition stable_neo_hookean() {
  PotentialDefinition definition = define_potential(
      "stable_neo_hookean", 4, "stable Neo-Hookean elasticity of linear tetrahedra", [](PotentialBuilder& b) {
        const Scalar E = b.parameter("youngs_modulus", "Pa", "Young's modulus");
        const Scalar nu = b.parameter("poissons_ratio", "1", "Poisson's ratio");
        const Scalar mu_small = E / (2.0 * (1.0 + nu));
        const Scalar lambda_small = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
        const Scalar mu = 4.0 / 3.0 * mu_small;
        const Scalar lambda = lambda_small + 5.0 / 6.0 * mu_small;
        const Scalar alpha = 1.0 + 0.75 * mu / lambda;

        const Mat3 F = deformation_gradient(b);
        const Scalar I_C = squared_norm(F), J = determinant(F);
        const Scalar rest = 0.5 * lambda * square(1.0 - alpha) - 0.5 * mu * std::log(4.0);
        const Scalar psi = 0.5 * mu * (I_C - 3.0) + 0.5 * lambda * square(J - alpha) -
                           0.5 * mu * log(I_C + 1.0) - rest;  // [J/m^3]
        return psi * rest_volume(b);
      });
  definition.zero_at_rest = true;
  definition.sample = [](std::mt19937_64& random) {
    PotentialSample sample;
    sample.values["poissons_ratio"] = {std::uniform_real_distribution<double>(0.0, 0.45)(random)};
    return sample;
  };
  return definition;
}

}  // namespace stark::models
