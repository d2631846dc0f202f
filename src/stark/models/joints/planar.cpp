// Planar joint: frame b moves in the x-y plane of frame a and turns about z.
#include <stark/models/joints/kinematics.h>

namespace stark::models {

JointDefinition planar() {
  return define_joint("planar", "displacements in the plane of frame a and rotation about its normal",
                      [](JointBuilder& j) {
                        const Vec3 d = j.b.origin - j.a.origin;
                        j.hold(dot(j.a.z, d), ResidualUnit::Length);
                        j.hold(j.a.z - j.b.z, ResidualUnit::Angle);
                        j.coordinate("displacement_x", dot(j.a.x, d), "m");
                        j.coordinate("displacement_y", dot(j.a.y, d), "m");
                        j.coordinate("angle", turn_about_z(j), "rad");
                      });
}

}  // namespace stark::models
