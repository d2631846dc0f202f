// Point on axis: the origin of frame b stays on the z axis of frame a; b turns freely.
#include <stark/models/joints/kinematics.h>

namespace stark::models {

JointDefinition point_on_axis() {
  return define_joint("point_on_axis", "the origin of frame b stays on the z axis of frame a",
                      [](JointBuilder& j) {
                        const Vec3 d = j.b.origin - j.a.origin;
                        j.hold(dot(j.a.x, d), ResidualUnit::Length);
                        j.hold(dot(j.a.y, d), ResidualUnit::Length);
                        j.coordinate("displacement", dot(j.a.z, d), "m");
                      });
}

}  // namespace stark::models
