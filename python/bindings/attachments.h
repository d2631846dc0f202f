// Attachments at the border.
#pragma once

#include <nanobind/nanobind.h>

#include <stark/sim/simulation.h>

#include "arrays.h"

namespace stark::bindings {

/// {"name", "a": points, "b": [points], "patch_body", "patches" (n, 3), "break_force", "enabled"} -> index
int32_t add_attachment(Scene& scene, const nb::dict& given);
void bind_attachments_of_scene(nb::handle type);
void bind_attachments_of_simulation(nb::handle type);

}  // namespace stark::bindings
