// Gear: couples the coordinates of two joints, q = ratio q' + offset. Gears, belts, racks, mimic joints of
// grippers. Held within the tolerances of joints.
#include <stark/mechanics/define.h>

namespace stark::models {

ActuatorDefinition gear() {
  ActuatorDefinition definition =
      define_actuator("gear", "couples the coordinates of two joints", [](ActuatorBuilder& a) {
        const Scalar ratio = a.parameter("ratio", a.unit(0) + "/" + a.unit(1),
                                         "change of the coordinate per change of the other");
        const Scalar offset =
            a.parameter("offset", a.unit(), "coordinate where the other one is zero", any_number(), 0.0);
        a.hold(a.q(0) - ratio * a.q(1) - offset);
        return Scalar(0.0);
      });
  definition.coordinate_count = 2;
  return definition;
}

}  // namespace stark::models
