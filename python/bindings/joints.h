// Joints at the border.
#pragma once

#include <nanobind/nanobind.h>

#include <stark/sim/simulation.h>

#include "arrays.h"

namespace stark::bindings {

/// {"name", "definition", "a": frame, "b": frame, "values": {...}, "enabled"} -> index
int32_t add_joint(Scene& scene, const nb::dict& given);
/// (force, torque) on frame b.
nb::tuple joint_reaction(const Simulation& simulation, int32_t joint);

}  // namespace stark::bindings
