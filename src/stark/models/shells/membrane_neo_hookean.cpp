// Neo-Hookean membrane energy of triangles in plane stress.
// psi = mu/2 (I_C - 2) - mu ln J + lambda/2 (ln J)^2 with I_C = tr C, J = sqrt(det C) the ratio of areas and
// the plane-stress lambda = E nu / (1 - nu^2). J > 0 for every embedded triangle that has an area, and psi
// grows without bound as the area vanishes. [theory eq. 11]
#include <stark/models/elastic_constants.h>
#include <stark/models/shells/metric.h>

namespace stark::models {

namespace {

Scalar neo_hookean_density(const LameConstants& constants, const Scalar& I_C, const Scalar& log_J) {
  const auto [mu, lambda] = constants;
  return 0.5 * mu * (I_C - 2.0) - mu * log_J + 0.5 * lambda * square(log_J);  // [J/m^3]
}

}  // namespace

/// The same as a law of the deformation gradient, for rest states that change (mechanics/rest_state.h).
ShellLaw membrane_neo_hookean_law() {
  return define_shell_law("membrane_neo_hookean", "Neo-Hookean membrane elasticity",
                          [](PotentialBuilder& b, const ShellDeformation& deformation) {
                            const LameConstants constants = plane_stress_constants(b);
                            const Mat32 F = deformation.F();
                            const Mat2 C = transpose(F) * F;
                            return neo_hookean_density(constants, C(0, 0) + C(1, 1),
                                                       0.5 * log(determinant(C)));
                          });
}

PotentialDefinition membrane_neo_hookean() {
  PotentialDefinition definition = define_potential(
      "membrane_neo_hookean", 3, "Neo-Hookean membrane elasticity of triangles", [](PotentialBuilder& b) {
        const LameConstants constants = plane_stress_constants(b);
        const Scalar thickness = b.parameter("thickness", "m", "thickness of the sheet", positive());

        const Metric G = rest_metric(b), g = current_metric(b);
        const Scalar I_C = (G.g22 * g.g11 - 2.0 * G.g12 * g.g12 + G.g11 * g.g22) / G.determinant();
        const Scalar log_J = 0.5 * log(g.determinant() / G.determinant());
        return neo_hookean_density(constants, I_C, log_J) * thickness * rest_area(b);
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
