// Force and torque of a joint, of the multipliers and penalties that its batch has. Phases: end of a step,
// queries.
#pragma once

#include <span>

#include <stark/mechanics/constraint_set.h>
#include <stark/mechanics/state.h>
#include <stark/sim/joint.h>

namespace stark {

/// On what carries frame b, about its origin; `joint` is the number in the constraints, x by site [m].
Wrench joint_wrench(const JointDescription& description, const ConstraintSet& constraints, int32_t joint,
                    std::span<const Vec3> x);

/// Nothing pulls any more with these residuals of what is released, broken or placed elsewhere.
void let_go(State& state, int64_t first_residual, size_t count);

}  // namespace stark
