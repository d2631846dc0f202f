// Position servo: PID controller with a cap, taken implicitly. The effort is that of the end of the step,
//   e = kp (target - q) + ki I + kd (target_rate - rate) + feedforward,  I = I_start + h (target - q),
// cut at +-cap. e is linear in q with slope -K, K = kp + ki h + kd / h, so the energy is huber(e, cap) / K.
// The integral rests while the cap is reached and the error would wind it up further. [theory eq. 34]
#include <stark/models/actuators/huber.h>

namespace stark::models {

ActuatorDefinition position_servo() {
  return define_actuator(
      "position_servo", "PID controller of the coordinate with at most cap", [](ActuatorBuilder& a) {
        const Scalar target = a.parameter("target", a.unit(), "coordinate to be reached");
        const Scalar kp =
            a.parameter("stiffness", a.stiffness_unit(), "effort per error (P)", non_negative());
        const Scalar kd =
            a.parameter("damping", a.damping_unit(), "effort per error of the rate (D)", non_negative());
        const Scalar ki = a.parameter("integral", a.stiffness_unit() + "/s", "effort per error and time (I)",
                                      non_negative(), 0.0);
        const Scalar cap = a.parameter("cap", a.effort_unit(), "largest effort", positive());
        const Scalar target_rate =
            a.parameter("target_rate", a.rate_unit(), "rate to be reached", any_number(), 0.0);
        const Scalar feedforward =
            a.parameter("feedforward", a.effort_unit(), "effort at no error", any_number(), 0.0);
        const Scalar error = target - a.q();
        const Scalar start = a.memory("integral", a.unit() + " s", "integral of the error");
        const Scalar wound = start + a.duration() * error;
        const Scalar e = kp * error + ki * wound + kd * (target_rate - a.rate()) + feedforward;
        a.remember("integral", select(abs(e) <= cap || e * error < 0.0, wound, start));
        // Gains of zero: e is constant, and any K does.
        const Scalar K = kp + ki * a.duration() + kd / a.time_step();
        return select(K > 0.0, huber(e, cap) / max(K, 1e-300), -max(-cap, min(feedforward, cap)) * a.dq());
      });
}

}  // namespace stark::models
