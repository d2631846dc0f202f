// Strain-rate (Kelvin-Voigt) damping of solids as an incremental law:
// psi = eta/(2 h) |E(F) - E(F_n)|^2 with the Green strain E = (F^T F - 1)/2. It is invariant under rotations,
// and its stress eta dE/dt does not depend on the time step. eta is the Rayleigh factor times the stiffness.
// [theory eq. 15]
#include <stark/mechanics/define.h>

namespace stark::models {

SolidLaw solid_damping() {
  return define_solid_law(
      "solid_damping", "strain-rate damping", [](PotentialBuilder& b, const SolidDeformation& deformation) {
        const Scalar eta =
            b.parameter("strain_damping", "Pa s", "viscosity of the Green strain rate", non_negative());
        const Mat3 F = deformation.F();
        const Mat3 C_prev = b.reference([&](auto point) {
          const Mat3 G = deformation.F_of(point);
          return transpose(G) * G;
        });
        const Mat3 increment = 0.5 * (transpose(F) * F - C_prev);
        return eta / (2.0 * b.time_step()) * squared_norm(increment);
      });
}

}  // namespace stark::models
