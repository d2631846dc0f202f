// Friction in a joint: dry, with an effort of at most cap that is reached at the rate stick_rate, and
// viscous. Below stick_rate, s = |rate| / stick_rate, the dry effort is cap (2 s - s^2), as in contact:
// smooth, and a joint under less than cap creeps with less than stick_rate. [theory eq. 36]
#include <stark/mechanics/define.h>

namespace stark::models {

ActuatorDefinition joint_friction() {
  ActuatorDefinition definition =
      define_actuator("joint_friction", "dry and viscous friction", [](ActuatorBuilder& a) {
        const Scalar cap =
            a.parameter("cap", a.effort_unit(), "largest effort of dry friction", non_negative());
        const Scalar stick =
            a.parameter("stick_rate", a.rate_unit(), "rate from which on dry friction is cap", positive());
        const Scalar viscous =
            a.parameter("viscous", a.damping_unit(), "effort per rate", non_negative(), 0.0);
        const Scalar s = abs(a.rate()) / stick;
        const Scalar dry = select(s < 1.0, square(s) * (1.0 - s / 3.0), s - 1.0 / 3.0);
        return a.time_step() * cap * stick * dry + 0.5 * viscous * a.rate() * a.dq();
      });
  definition.needs_rates = true;  // without rates it would let go of what it should hold
  return definition;
}

}  // namespace stark::models
