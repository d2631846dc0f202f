// Slider (prismatic joint): frame b moves along the z axis of frame a without turning.
#include <stark/models/joints/kinematics.h>

namespace stark::models {

JointDefinition slider() {
  return define_joint("slider", "displacement along the z axis of frame a", [](JointBuilder& j) {
    const Vec3 d = j.b.origin - j.a.origin;
    j.hold(dot(j.a.x, d), ResidualUnit::Length);
    j.hold(dot(j.a.y, d), ResidualUnit::Length);
    j.hold(j.a.x - j.b.x, ResidualUnit::Angle);
    j.hold(j.a.z - j.b.z, ResidualUnit::Angle);
    j.coordinate("displacement", dot(j.a.z, d), "m");
  });
}

}  // namespace stark::models
