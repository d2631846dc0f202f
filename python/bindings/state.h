// The state of a simulation as a value, for Python.
#pragma once

#include <nanobind/nanobind.h>

#include <cstdint>
#include <string>

namespace stark::bindings {

/// Sixteen digits.
std::string hex(uint64_t value);

void bind_state(nanobind::module_& m);

}  // namespace stark::bindings
