// Force and torque of a joint, of the multipliers and penalties that its batch has. Phases: end of a step,
// queries.
#pragma once

#include <array>
#include <span>
#include <string>

#include <stark/mechanics/constraint_set.h>
#include <stark/mechanics/state.h>
#include <stark/sim/scene/joint.h>

namespace stark {

/// Origin [m] and axes, as columns, of a frame of a joint.
struct JointFrame {
  Vec3 origin;
  Mat3 axes;
};
/// One that three vertices at p carry, by its numbers in the field `placement` (mechanics/joint.h,
/// kPatchNumbers).
JointFrame frame_on_patch(const ConstraintGroup& group, int64_t element, const std::string& placement,
                          const std::array<Vec3, 3>& p);

/// On what carries frame b, about its origin; `joint` is the number in the constraints, x by site [m].
Wrench joint_wrench(const JointDescription& description, const ConstraintSet& constraints, int32_t joint,
                    std::span<const Vec3> x);

/// Nothing pulls any more with these residuals of what is released, broken or placed elsewhere.
void let_go(State& state, int64_t first_residual, size_t count);

}  // namespace stark
