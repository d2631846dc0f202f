// The state of a simulation as a value, for Python.
#pragma once

#include <cstdint>
#include <string>

namespace stark::bindings {

/// Sixteen digits.
std::string hex(uint64_t value);

}  // namespace stark::bindings
