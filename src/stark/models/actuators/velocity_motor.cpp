// Velocity motor: drives the rate of a coordinate to a target with an effort that grows in proportion to the
// difference up to the cap, which it reaches at the difference delta and never exceeds [Stark paper, fig. 2:
// k = cap / delta, theta = delta / 2]. Energy of a step: h Phi(target - rate), so that -dE/dq = Phi'.
// [theory eq. 33]
#include <stark/models/actuators/huber.h>

namespace stark::models {

ActuatorDefinition velocity_motor() {
  ActuatorDefinition definition = define_actuator(
      "velocity_motor", "drives the rate to a target with at most cap", [](ActuatorBuilder& a) {
        const Scalar target = a.parameter("target", a.rate_unit(), "rate to be reached");
        const Scalar cap = a.parameter("cap", a.effort_unit(), "largest effort", non_negative());
        const Scalar delta = a.parameter("delta", a.rate_unit(),
                                         "difference of rates at which the cap is reached", positive());
        return a.time_step() * cap / delta * huber(target - a.rate(), delta);
      });
  definition.needs_rates = true;
  return definition;
}

}  // namespace stark::models
