// Distance: the origins keep a distance, as if joined by a rod without mass.
#include <stark/models/joints/kinematics.h>

namespace stark::models {

JointDefinition distance() {
  return define_joint("distance", "the origins keep a distance", [](JointBuilder& j) {
    const Scalar length = j.parameter("length", "m", "distance of the origins");
    j.hold(norm(j.b.origin - j.a.origin) - length, ResidualUnit::Length);
  });
}

}  // namespace stark::models
