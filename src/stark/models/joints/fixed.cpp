// Fixed joint (weld): frames coincide.
#include <stark/models/joints/kinematics.h>

namespace stark::models {

JointDefinition fixed() {
  return define_joint("fixed", "the two frames coincide", [](JointBuilder& j) {
    j.hold(j.a.origin - j.b.origin, ResidualUnit::Length);
    j.hold(j.a.x - j.b.x, ResidualUnit::Angle);
    j.hold(j.a.z - j.b.z, ResidualUnit::Angle);
  });
}

}  // namespace stark::models
