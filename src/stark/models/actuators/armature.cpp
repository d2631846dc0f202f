// Armature: inertia that moves with the coordinate and is part of neither body, as the rotor of a geared
// motor (rotor inertia times the square of the gear ratio). Effort -J d(rate)/dt. [theory eq. 37]
#include <stark/mechanics/define.h>

namespace stark::models {

ActuatorDefinition armature() {
  return define_actuator("armature", "inertia of the coordinate", [](ActuatorBuilder& a) {
    const Scalar J = a.parameter("inertia", a.unit() == "rad" ? "kg m^2" : "kg",
                                 "effort per acceleration of the coordinate", non_negative());
    return 0.5 * J * square(a.rate() - a.rate_start());
  });
}

}  // namespace stark::models
