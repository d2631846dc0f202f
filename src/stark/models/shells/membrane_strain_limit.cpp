// Limit of the strain of membranes: psi = k/3 S (1 + hardening S/(S + limit^3)), S = sum_i max(0, e_i -
// limit)^3 over the eigenvalues e_i of the Green strain in the plane; published without hardening. [theory
// eq. 14]
#include <stark/models/shells/metric.h>
#include <stark/models/strain_excess.h>

namespace stark::models {

/// The same as a law of the deformation gradient, for rest states that change (mechanics/rest_state.h).
ShellLaw membrane_strain_limit_law() {
  return define_shell_law("membrane_strain_limit", "limit of the eigenvalues of the Green strain",
                          [](PotentialBuilder& b, const ShellDeformation& deformation) {
                            const Scalar limit = strain_limit_parameter(b);
                            const Mat32 F = deformation.F();
                            const Mat2 A = 0.5 * (transpose(F) * F) - (0.5 + limit) * Mat2::identity();
                            const Scalar S = positive_cubes(trace(A), determinant(A));
                            return strain_limit_density(b, limit, S);
                          });
}

PotentialDefinition membrane_strain_limit() {
  PotentialDefinition definition = define_potential(
      "membrane_strain_limit", 3, "limit of the eigenvalues of the Green strain of triangles",
      [](PotentialBuilder& b) {
        const Scalar limit = strain_limit_parameter(b);
        const Scalar thickness = b.parameter("thickness", "m", "thickness of the sheet", positive());
        const MixedTensor C = mixed(rest_metric(b), current_metric(b));
        // Mixed components of E - limit, whose eigenvalues are those of the matrix in an orthonormal frame.
        const Scalar shift = 0.5 + limit, a11 = 0.5 * C.c11 - shift, a22 = 0.5 * C.c22 - shift;
        const Scalar S = positive_cubes(a11 + a22, a11 * a22 - 0.25 * C.c12 * C.c21);
        return strain_limit_density(b, limit, S) * thickness * rest_area(b);
      });
  definition.zero_at_rest = true;
  definition.one_sided = true;
  definition.sample = [](std::mt19937_64& random) {
    std::uniform_real_distribution<double> limit(0.002, 0.02);
    PotentialSample sample;
    sample.values["strain_limit"] = {limit(random)};
    return sample;
  };
  return definition;
}

}  // namespace stark::models
