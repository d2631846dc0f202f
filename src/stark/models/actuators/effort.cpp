// Effort: a given force or torque along a coordinate.
#include <stark/mechanics/define.h>

namespace stark::models {

ActuatorDefinition effort() {
  return define_actuator("effort", "a given force or torque", [](ActuatorBuilder& a) {
    return -a.parameter("target", a.effort_unit(),
                        "force or torque, positive where it raises the coordinate") *
           a.dq();
  });
}

}  // namespace stark::models
