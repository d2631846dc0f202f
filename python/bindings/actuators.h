// Actuators at the border.
#pragma once

#include <nanobind/nanobind.h>

#include <stark/sim/simulation.h>

#include "arrays.h"

namespace stark::bindings {

/// {"name", "definition", "on": [(joint, coordinate)], "values": {name: number}, "enabled"} -> index
int32_t add_actuator(Scene& scene, const nb::dict& given);

}  // namespace stark::bindings
