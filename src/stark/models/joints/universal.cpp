// Universal joint (Cardan): origins coincide, the x axis of frame a stays perpendicular to the y axis of
// frame b.
#include <stark/models/joints/kinematics.h>

namespace stark::models {

JointDefinition universal() {
  return define_joint("universal", "two rotations, about the x axis of frame a and the y axis of frame b",
                      [](JointBuilder& j) {
                        j.hold(j.a.origin - j.b.origin, ResidualUnit::Length);
                        j.hold(dot(j.a.x, j.b.y), ResidualUnit::Angle);
                        j.coordinate("angle_a", atan2(dot(j.b.y, j.a.z), dot(j.b.y, j.a.y)), "rad");
                        j.coordinate("angle_b", atan2(dot(j.a.x, j.b.z), dot(j.a.x, j.b.x)), "rad");
                      });
}

}  // namespace stark::models
