// Spring and damper: effort -k (q - rest) - c rate. [theory eq. 35]
#include <stark/mechanics/define.h>

namespace stark::models {

ActuatorDefinition spring_damper() {
  return define_actuator("spring_damper", "linear spring with linear damper", [](ActuatorBuilder& a) {
    const Scalar k = a.parameter("stiffness", a.stiffness_unit(), "effort per extension", non_negative());
    const Scalar rest = a.parameter("rest", a.unit(), "coordinate without effort of the spring");
    const Scalar c = a.parameter("damping", a.damping_unit(), "effort per rate", non_negative(), 0.0);
    return 0.5 * k * square(a.q() - rest) + 0.5 * c * a.rate() * a.dq();
  });
}

}  // namespace stark::models
