// Orientation: frames do not turn against each other; origins are free.
#include <stark/models/joints/kinematics.h>

namespace stark::models {

JointDefinition orientation() {
  return define_joint("orientation", "the axes of the frames are aligned", [](JointBuilder& j) {
    j.hold(j.a.x - j.b.x, ResidualUnit::Angle);
    j.hold(j.a.z - j.b.z, ResidualUnit::Angle);
  });
}

}  // namespace stark::models
