// Strain-rate (Kelvin-Voigt) damping of linear tetrahedra as an incremental potential:
// E = eta V/(2 h) |E(x) - E(x_n)|^2 with the Green strain E = (F^T F - I)/2. It is invariant under rotations,
// and its force eta dE/dt does not depend on the time step. eta is the Rayleigh factor times the stiffness.
// [theory eq. 15]
#include <stark/models/solids/deformation.h>

namespace stark::models {

PotentialDefinition solid_damping() {
  PotentialDefinition definition = define_potential(
      "solid_damping", 4, "strain-rate damping of linear tetrahedra", [](PotentialBuilder& b) {
        const Scalar eta = b.parameter("strain_damping", "Pa s", "viscosity of the Green strain rate");
        const Mat3 F = deformation_gradient(b), F_prev = previous_deformation_gradient(b);
        const Mat3 increment = 0.5 * (transpose(F) * F - transpose(F_prev) * F_prev);
        return eta * rest_volume(b) / (2.0 * b.time_step()) * squared_norm(increment);
      });
  definition.zero_at_rest = true;
  return definition;
}

}  // namespace stark::models
