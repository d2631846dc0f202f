// Direction: z axes are aligned; origins are free.
#include <stark/models/joints/kinematics.h>

namespace stark::models {

JointDefinition direction() {
  return define_joint("direction", "the z axes are aligned", [](JointBuilder& j) {
    j.hold(j.a.z - j.b.z, ResidualUnit::Angle);
    j.coordinate("angle", turn_about_z(j), "rad");
  });
}

}  // namespace stark::models
