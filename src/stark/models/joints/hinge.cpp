// Hinge (revolute joint): origins coincide, z axes are aligned; the angle turns frame b about z.
#include <stark/models/joints/kinematics.h>

namespace stark::models {

JointDefinition hinge() {
  return define_joint("hinge", "rotation about the common z axis", [](JointBuilder& j) {
    j.hold(j.a.origin - j.b.origin, ResidualUnit::Length);
    j.hold(j.a.z - j.b.z, ResidualUnit::Angle);
    j.coordinate("angle", turn_about_z(j), "rad");
  });
}

}  // namespace stark::models
