// Tilt: holds nothing and measures the angle between the z axes. Next to a ball joint and with an upper limit
// it is the cone that the axis stays in.
#include <stark/models/joints/kinematics.h>

namespace stark::models {

JointDefinition tilt() {
  return define_joint("tilt", "measures the angle between the z axes; for cones", [](JointBuilder& j) {
    // Aligned axes have no direction to tilt in.
    const Scalar s = squared_norm(cross(j.a.z, j.b.z));
    j.coordinate("angle", atan2(sqrt(max(s, 1e-24)), dot(j.a.z, j.b.z)), "rad");
  });
}

}  // namespace stark::models
