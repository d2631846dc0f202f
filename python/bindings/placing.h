// Placing of bodies between steps at the border.
#pragma once

#include <nanobind/nanobind.h>

namespace stark::bindings {

void bind_placing_of_simulation(nanobind::handle type);

}  // namespace stark::bindings
