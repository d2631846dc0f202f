// Ball joint: origins coincide.
#include <stark/models/joints/kinematics.h>

namespace stark::models {

JointDefinition ball() {
  return define_joint("ball", "the two origins coincide",
                      [](JointBuilder& j) { j.hold(j.a.origin - j.b.origin, ResidualUnit::Length); });
}

}  // namespace stark::models
