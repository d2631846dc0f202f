// Strain-rate damping of triangles as an incremental potential: E = d A/(2 h) |E(x) - E(x_n)|^2 with the
// Green strain E = (C - I)/2. d is the Rayleigh factor times thickness times Young's modulus. [theory eq. 15]
#include <stark/models/shells/metric.h>

namespace stark::models {

PotentialDefinition membrane_damping() {
  PotentialDefinition definition =
      define_potential("membrane_damping", 3, "strain-rate damping of triangles", [](PotentialBuilder& b) {
        const Scalar d =
            b.parameter("strain_damping", "N s/m", "viscosity of the Green strain rate", non_negative());
        const Metric G = rest_metric(b), g = current_metric(b), g_prev = reference_metric(b);
        const Metric change{g.g11 - g_prev.g11, g.g12 - g_prev.g12, g.g22 - g_prev.g22};
        const MixedTensor D = mixed(G, change);  // C - C_n
        const Scalar squared = 0.25 * (square(D.c11) + 2.0 * D.c12 * D.c21 + square(D.c22));
        return d * rest_area(b) / (2.0 * b.time_step()) * squared;
      });
  definition.zero_at_rest = true;
  return definition;
}

}  // namespace stark::models
