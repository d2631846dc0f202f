// What the formulas of several joints share.
#pragma once

#include <stark/mechanics/define.h>

namespace stark::models {

/// Rotation of frame b against frame a about the common z axis [rad], in (-pi, pi].
inline Scalar turn_about_z(const JointBuilder& j) { return atan2(dot(j.b.x, j.a.y), dot(j.b.x, j.a.x)); }

}  // namespace stark::models
