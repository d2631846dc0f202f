// Inertia of a lumped mass as an incremental potential, with mass damping.
// E = m/2 |x - x_hat|^2 / s^2 + m a/(2 h) |x - x_n|^2, x_hat the inertial prediction and s the integrator's
// scale (h for implicit Euler, infinite for quasistatics). [theory eq. 8, 9]
//
// The same potential on the axis directions of a rigid body, with the second moments of mass in place of m,
// is the rotational inertia in trace form, 1/(2 s^2) tr((R - R_hat) J_bar (R - R_hat)^T): the gyroscopic
// torque is included.
#include <stark/mechanics/define.h>

namespace stark::models {

PotentialDefinition point_inertia() {
  PotentialDefinition definition = define_potential(
      "point_inertia", 1, "inertia of a lumped mass with mass damping", [](PotentialBuilder& b) {
        const Scalar mass = b.data("mass", "kg", "lumped mass, or second moment [kg m^2] of a direction");
        const Vec3 predicted = b.data3("predicted", "m", "position without forces at the end of the step");
        const Scalar damping = b.data("damping", "1/s", "rate at which free motion decays");
        const Scalar inverse_scale =
            b.parameter("inverse_scale_squared", "1/s^2", "1/(sigma s) of the integrator, 0: quasistatic");
        const Scalar inertia = inverse_scale * squared_norm(b.x(0) - predicted);
        const Scalar drag = damping / b.time_step() * squared_norm(b.x(0) - b.x_prev(0));
        return 0.5 * mass * (inertia + drag);
      });
  definition.translation_invariant = definition.rotation_invariant = false;
  return definition;
}

}  // namespace stark::models
