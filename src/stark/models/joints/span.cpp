// Span: holds nothing and measures the distance of the origins. With actuators it becomes a spring, a rope
// (upper limit), a strut or a linear drive.
#include <stark/models/joints/kinematics.h>

namespace stark::models {

JointDefinition span() {
  return define_joint("span", "measures the distance of the origins; for springs, ropes and drives",
                      [](JointBuilder& j) {
                        // Coinciding origins have no direction to act along.
                        const Scalar s = squared_norm(j.b.origin - j.a.origin);
                        j.coordinate("distance", sqrt(max(s, 1e-24)), "m");
                      });
}

}  // namespace stark::models
