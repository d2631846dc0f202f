// Cylindrical joint: frame b moves along the z axis of frame a and turns about it.
#include <stark/models/joints/kinematics.h>

namespace stark::models {

JointDefinition cylindrical() {
  return define_joint("cylindrical", "displacement along the z axis of frame a and rotation about it",
                      [](JointBuilder& j) {
                        const Vec3 d = j.b.origin - j.a.origin;
                        j.hold(dot(j.a.x, d), ResidualUnit::Length);
                        j.hold(dot(j.a.y, d), ResidualUnit::Length);
                        j.hold(j.a.z - j.b.z, ResidualUnit::Angle);
                        j.coordinate("displacement", dot(j.a.z, d), "m");
                        j.coordinate("angle", turn_about_z(j), "rad");
                      });
}

}  // namespace stark::models
